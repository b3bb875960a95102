"""What is no box of the paper: streams, buffers, tables, arithmetic."""
