"""All that is known of ECP5: its devices, its block RAM, how the core is mapped to it and timed."""
