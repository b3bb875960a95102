"""All that is known of Cyclone IV: its cells, its memories, how logic is packed into it."""
