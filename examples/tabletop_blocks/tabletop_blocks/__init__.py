"""A second domain: coloured blocks on a table, moved by a hand.

Nothing of the forklift is in it: lengths are centimetres where the warehouse has metres, the
robot is a hand, and what it does is stack. The toolkit learns of it by entry points only. Read
`block_scenes` first (things and the hand's tasks), then `block_phrases` (commands for
them), `importer` (both as a corpus) and `features`.
"""
