"""The edges of the core: what stands between the detector and buses that other people's cores speak."""
