"""cocotb test benches: modules that run inside the simulator, started by tests through
:mod:`sim.cocotb_bench`.
"""
