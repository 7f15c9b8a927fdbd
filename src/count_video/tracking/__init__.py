"""Frames to positions with uncertainty.

``observation`` decodes a clip once and yields every rigid body that moves in it: ``bodies`` finds
them in samples, ``learning`` learns them, ``following`` registers them in every picture.
``pairing`` and ``single`` make the track of two bodies that could collide, or of one alone.
"""
