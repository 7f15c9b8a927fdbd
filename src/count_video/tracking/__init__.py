"""Frames to positions with uncertainty.

``track`` follows two bodies that could collide, ``lone`` whatever else moves. What they are made of
stands in alcoves: ``pairs`` finds two bodies, ``looks`` tells where in a picture each is,
``steadying`` how the camera moved, ``silhouettes`` follows a body whose markings change, and
``patches`` what stands out from the scenery.
"""
