"""Parts that are not blocks of the paper's Fig. 9: streams, buffers, tables, arithmetic."""
