#error "ERA201D1 is refused: a simulated robot has no wireless card to ask for its state"
