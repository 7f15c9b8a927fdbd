"""What is expected before the places of a clip are seen: all priors of the inference.

Values with an uncertainty are normal. Where nothing is known of real clips, the source is named as
an estimate.
"""

from __future__ import annotations

from typing import Final

# Contacts and flights: the joint fit.

PARALLAX_SIGMA: Final = 0.05
"""Growth of the distance at contact with the place, px per px: cameras some metres away."""
TIME_MOVES_FRAMES: Final = 1.5
"""A contact lies in one of the steps next to the frame where it is sought."""
CONTACT_STRAY_SHARE: Final = 0.4
"""Contacts stray from one place by this share of the noise of a frame: outlines are measured a
little off where they lie unluckily on the pixels (0.02 px on rendered clips, truth known)."""
CAUCHY_SIGMAS: Final = 3.0
"""From here on a residual counts less than its square, as with Cauchy errors: a tracker is misled
now and then."""
CLEAR_FRAMES: Final = 0.6
"""Frames nearer to a collision may hold it in their exposure."""
TURN_LOG_RATIO: Final = 2.0
"""A low point is a turn from this logarithm of the likelihood ratio on: most are collisions."""

# Two pendulums and a wall: the fit of a whole burst.

USUAL_RATE_PER_S: Final = 3.13
"""Angular rate of a thread of 1 m, radians per second."""
RATE_SIGMA: Final = 0.3
"""Of its logarithm: threads from half a metre to two."""
USUAL_CAPTURE_FPS: Final = 350.0
RATE_SIGMA_UNKNOWN: Final = 0.7
"""The same where the capture rate is not known: it lies between 120 and 1000 frames per second, all
of them as likely by their logarithm."""
BALL_RATE_SIGMA: Final = 0.05
"""Of the logarithm of the ball's rate over the heavy body's: both hang from one height."""
DAMPING: Final = (-6.0, 1.0)
"""Mean and standard deviation of the logarithm of the ball's damping ratio: 4 k V / (3 pi m w) for
drag k v^2 at the speed V, with k 0.45 of half the air's density times the section. That gives 10 g
and 40 mm on threads of 1 m 0.001 to 0.007 at 0.2 to 1.5 m/s."""
PULL_SHARE: Final = 0.3
"""The heavy body hangs from the ball's rest by about this share of the ball's way to the wall."""
EXPOSURE: Final = (0.5, 0.3)
"""Mean and standard deviation of the part of a frame during which the shutter is open."""
LIGHTNESS: Final = (-3.5, 1.75)
"""Mean and standard deviation of the logarithm of the ball's mass over a heavy body's that is not
seen: set-ups from 1:1 to 1:1000 lie within two of them, 1:100 in the middle of the usual ones."""
GIVEN_RATIO_SHARE: Final = 0.002
"""Standard uncertainty of a mass ratio that is given, as a share: scales, and a ring of thread."""
SHOWN_RATIO_SHARE: Final = 0.01
"""That of a mass ratio which the motion shows, besides its own: what the model does not know."""
SWING_RATIO_SHARE: Final = 0.025
"""That of a mass ratio by the heavy body's swing alone, besides its own: on 105 rendered clips of
known truth such ratios stray by so much more, as a root mean square."""
RESTITUTION: Final = (0.95, 0.1)
"""Mean and standard deviation of hard bodies' restitution."""
SPEED: Final = (0.0, 0.03)
"""Mean and standard deviation of how much less the restitution is at the speed of the first
collision than at none: of elastic bodies 1 - e grows as the fifth root of the speed (Ramirez et al.
1999), by which a restitution of 0.95 is higher by 0.02 at a tenth of it."""
SCATTERS: Final = (0.0002, 0.001, 0.005, 0.02)
"""Standard deviations of the restitution from collision to collision that are tried."""

LEFT_OUT: Final = 0.02
"""Share of clips in which frames of the burst are left out without a trace, anywhere in it and up
to a second's fraction of them: an estimate."""

# Impacts of one body alone, or of two without a wall: chances, estimates all of them.

CHANCE_CLEAR: Final = 0.995
CHANCE_CUT_OFF: Final = 0.5
"""Chances that an impact is one that seems certain, and that a clip which begins or ends with the
body at its stop shows one more."""
CHANCE_UNSEEN: Final = 0.3
"""Chance that an impact lies before the first one, in pictures that do not show the body; and that
none does where the body is due at its stop after the last one that is seen."""
CHANCE_DYING: Final = 0.25
"""Where the flights shrink below what pictures show, the chance that these show one more impact:
where that limit lies is known to about one flight."""
CHANCES_LOST: Final = (0.6, 0.25, 0.15)
"""Where impacts follow each other faster than pictures resolve them, or the body must have fallen
back to its stop while the clip went on, the chances of one more and of each after it."""
PARTNER_UNSEEN: Final = 0.5
"""Chance that a body alone which turns once or twice is the heavy body of a trial whose ball could
not be followed: so it was with 3 of 5 clips that were not made by this project."""
STANDS_STILL: Final = (0.7, 0.3)
"""Chances that nothing seems to move where a body turns, if it strikes what stands still (but for
shadows and reflections), and if it strikes a ball that could not be followed: an estimate."""
FLIGHT_FACTOR: Final = 1.6
"""A flight is at most so much longer than the others: bodies that lose 60 % of their speed at an
impact are hardly said to bounce."""

# What no model knows.

MODEL_WRONG: Final = 0.004
"""Share of counts that turn out wrong for reasons outside the model, one for all clips. Of
997 counts of random trials with claims above 0.95 three were wrong (446 rendered clips, 551 tracks;
docs/accuracy.md), which by Jeffreys' prior is (3 + 1/2) / (997 + 1). Real clips with a known truth
are too few to measure it by."""
LEFT_OVER: Final = (1.5, 1.7)
"""What a fit usually leaves over of the places, as a multiple of their noise (the median of 878
rendered clips), and the power of it with which the share of wrong counts grows where collisions are
inferred. Of 40 drawn clips that leave over more than five times the noise none is wrong, of 30
tracks of bodies that do what no model knows (a cylinder that yaws, a wall that recoils) nine; from
2.5 to five times it is none of 18 and four of 37. One clip in seven is taken for such a one."""
UNEXPLAINED_WRONG: Final = 0.15
"""Probability that a count is wrong where something about it is not explained: no fitted model
describes the motion, or collisions are inferred though outlines do not meet where the bodies touch.
Of 376 tracks counted rightly one in nineteen strays from the model, of those counted wrongly two of
three (frames cut out of clips, truth known); these are taken for one in 70. Of 22 counts with such
outlines four are wrong (clips of other renderers).
"""

# One body's path: its turns, and its stops.

TURNS: Final = (0.5, 0.2, 0.25, 0.05)
"""What a turn is before its shape is seen: an impact, that of a swing or a throw, that of a path
that a hand leads, or one misplaced picture; estimates."""
CONTACT_SHARE: Final = 0.04
CONTACT_PICTURES: Final = 5.6
"""Half the longest contact over the usual flight, and at most in pictures: bumpers are springs, and
soft balls touch for several pictures of a fast camera."""
NOISE_KNOWN: Final = 4.0
"""Degrees of freedom by which the noise of places is known beforehand: to about a third."""
NO_BOUNCE: Final = -5.0
"""Logarithm of the odds of an impact by whose best fit the body does not bounce, at the most."""
STOP_SHARE: Final = 0.08
"""Impacts on one stop lie within this share of the body's way, as cameras see it obliquely."""
HAND_JUMPS: Final = 0.2
"""Chance that a clip shows a corner of the path which a hand or a knock makes: an estimate."""
