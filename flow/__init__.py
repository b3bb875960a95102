"""From the hardware to other tools: Verilog, packages, synthesis, Quartus, formal proofs."""
