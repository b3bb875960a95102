"""What leaves the house: Verilog."""
