"""The hardware: every block of the paper's Fig. 9 in Amaranth, one file each, and the top level
that wires them.
"""
