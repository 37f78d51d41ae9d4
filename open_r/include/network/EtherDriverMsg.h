#error "EtherDriver is refused: a simulated robot has no network card to ask for its state"
