"""Frames to positions with uncertainty.

``moving`` finds and follows every rigid body that moves, from one decoding. Where that gives no
certain count, ``track`` follows two bodies that could collide, and ``lone`` whatever else moves.

What these share and are made of: ``looks`` registers a template in a picture, ``steadying``
measures how the camera moved, ``pairs`` finds two bodies in short runs of frames, ``silhouettes``
follows a body whose markings change, and ``patches`` what stands out from the background.
"""
