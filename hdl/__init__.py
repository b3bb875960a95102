"""The hardware in Amaranth: the blocks of the paper's Fig. 9, one file each, and the top level."""
