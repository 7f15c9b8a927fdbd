"""Every rigid body that moves in a clip, from one decoding: found, learnt, followed and paired."""
