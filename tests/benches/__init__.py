"""cocotb test benches: modules that tests run in the simulator by :mod:`sim.cocotb_bench`."""
