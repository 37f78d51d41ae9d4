#error "DNS is refused: a simulated robot reaches this machine alone. Use an address, 127.0.0.1"
