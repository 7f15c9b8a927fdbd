"""Conditions of the light, the camera's stand and lens, and the file and its times."""

from __future__ import annotations

from synth_video.suite.condition import Condition

_MOTTLED = (
    "background.kind=stone",
    "background.color=[128, 119, 110] | [92, 86, 80]",
    "ball.ring=false",
    'ball.mark=""',
    "ball.gloss=0.05",
    "light.shadow=0",
)
"""A sphere lit from the side is on average less bright than its colour; the balls' colours are so
much brighter than the wall."""
_DARK = (
    "light.brightness=0.11",
    "ball.color=[226, 226, 222] | [232, 176, 90] | [34, 34, 38]",
)

LIGHT = (
    Condition(
        "clean",
        "nothing special: what the others are measured against",
        (),
        ("camera.read_noise=1.5", "encoding.crf=26"),
    ),
    Condition(
        "noise",
        "noise of a standard deviation of 5 or 12 grey levels",
        ("camera.read_noise=5",),
        ("camera.read_noise=12", "camera.shot_noise=0"),
    ),
    Condition(
        "contrast",
        "a ball 30 or 15 grey levels from the background, evenly lit and without ring or print",
        (
            "background.kind=plaster",
            "background.texture=0.5",
            "ball.color=[160, 151, 142] | [100, 92, 84]",
        ),
        (
            "background.kind=plaster",
            "background.texture=0.5",
            "ball.color=[145, 136, 126] | [118, 109, 100]",
            "ball.shading=0.1",
            "ball.gloss=0",
            "ball.ring=false",
            'ball.mark=""',
        ),
    ),
    Condition(
        "camouflage",
        "a ball as bright as the mottled wall behind it, seen by its shading only, strong or weak",
        (
            *_MOTTLED,
            "background.texture=1.0",
            "ball.shading=1.0",
            "ball.color=[157, 146, 135] | [113, 106, 98]",
        ),
        (
            *_MOTTLED,
            "background.texture=1.8",
            "ball.shading=0.6",
            "ball.color=[144, 134, 124] | [104, 97, 90]",
        ),
    ),
    Condition(
        "dark",
        "so little light that all of the picture lies within 30 grey levels; also noisy",
        _DARK,
        (*_DARK, "camera.read_noise=2"),
    ),
    Condition(
        "flicker",
        "lamps that flicker with 100 or 120 Hz by 8 or 20 %",
        ("light.flicker_amplitude=0.08", "light.flicker_hz=100 | 120"),
        ("light.flicker_amplitude=0.2", "light.flicker_hz=100 | 120"),
    ),
    Condition(
        "drift",
        "a camera that sets its exposure anew: brightness falls or rises by 15 or 40 %",
        ("light.drift=-0.15 | 0.15",),
        ("light.drift=-0.4 | 0.4",),
    ),
)

STAND = (
    Condition(
        "shake",
        "a tripod that trembles by 1 or 3 px to each side with 5 to 20 Hz",
        ("tripod.shake_px=1",),
        ("tripod.shake_px=3",),
    ),
    Condition(
        "knock",
        "one knock against the tripod: the picture swings by 3 or 8 px",
        ("tripod.knock_px=3",),
        ("tripod.knock_px=8",),
    ),
    Condition(
        "tilt",
        "the line of motion runs 4 or 8 degrees off the picture's rows",
        ("camera.tilt_deg=-4 | 4", "view.line=0.46"),
        ("camera.tilt_deg=-8 | 8", "view.line=0.5", "camera.height_px=240"),
    ),
    Condition(
        "perspective",
        "a camera turned by 2 or 5 degrees",
        ("lens.turn_deg=-2 | 2",),
        ("lens.turn_deg=-5 | 5", "lens.distance_m=0.6"),
    ),
    Condition(
        "distortion",
        "a lens that bends straight lines by 3 or 8 % at the corners",
        ("lens.distortion=-0.03 | 0.03",),
        ("lens.distortion=-0.08 | 0.08",),
    ),
    Condition(
        "blur",
        "a shutter open the whole time, and a lens out of focus",
        ("camera.shutter=0.9",),
        ("camera.shutter=1.0", "camera.blur_px=1.5"),
    ),
    Condition(
        "small",
        "a ball 22 or 12 px across",
        ("view.width_m=0.87", "view.wall_m=0.25", "threads.width_m=0.0006"),
        ("view.width_m=1.6", "view.wall_m=0.55", "threads.width_m=0.001"),
    ),
    Condition(
        "wide",
        "a picture 1280 px wide with a ball of 46 px, or one of 30 px before something dark",
        (
            "camera.width_px=1280",
            "camera.height_px=490",
            "view.width_m=1.1",
            "view.wall_m=0.1",
            "threads.width_m=0.0006",
        ),
        (
            "camera.width_px=1280",
            "camera.height_px=720",
            "view.width_m=1.7",
            "view.wall_m=0.14 | 0.5",
            "threads.width_m=0.0008",
            "background.kind=cloth | stone | plaster",
            "background.color=[38, 36, 35]",
            "background.texture=0.5",
            "ball.color=[226, 226, 222] | [226, 103, 28] | [60, 110, 190]",
        ),
    ),
    Condition(
        "large",
        "a ball 130 or 250 px across, the cylinder mostly outside the picture",
        ("camera.width_px=640", "camera.height_px=280", "view.width_m=0.2", "clip.max_frames=300"),
        (
            "camera.width_px=1120",
            "camera.height_px=440",
            "view.width_m=0.18",
            "view.wall_m=0.03",
            "clip.max_frames=200",
        ),
    ),
)

FILE = (
    Condition(
        "compressed",
        "H.264 at a quality of CRF 30 or 38",
        ("encoding.crf=30",),
        ("encoding.crf=38",),
    ),
    Condition(
        "codec",
        "HEVC, VP9 and 10 bits; then at low quality",
        (
            "encoding.codec=libx265 | libvpx-vp9 | libx265",
            "encoding.pixel_format=yuv420p | yuv420p | yuv420p10le",
        ),
        (
            "encoding.codec=libx265 | libvpx-vp9 | libx265",
            "encoding.pixel_format=yuv420p | yuv420p | yuv420p10le",
            "encoding.crf=32",
        ),
    ),
    Condition(
        "mjpeg",
        "Motion JPEG in an AVI file, good and poor",
        ("encoding.codec=mjpeg", "encoding.crf=10"),
        ("encoding.codec=mjpeg", "encoding.crf=36"),
        suffix=".avi",
    ),
    Condition(
        "rotated",
        "stored on its side or its head, with the flag that turns it upright",
        ("encoding.rotation_deg=90 | 180 | 270",),
        (
            "encoding.rotation_deg=270 | 90 | 180",
            "camera.width_px=360",
            "camera.height_px=640",
            "view.width_m=0.27",
        ),
    ),
    Condition(
        "resolution",
        "1080p and 4K",
        ("camera.width_px=1920", "camera.height_px=1080", "clip.max_frames=160"),
        (
            "camera.width_px=3840",
            "camera.height_px=2160",
            "view.width_m=0.44",
            "clip.max_frames=110",
        ),
    ),
)


# ---- times ---------------------------------------------------------------------------------------
# Conditions of time: uneven rates, copies, and clips that show too much or too little.

RATE = (
    Condition(
        "uneven",
        "a variable rate: exposures off their time by up to 3 or 15 % of a frame, stamped truly",
        ("camera.jitter=0.03", "encoding.variable_rate=true"),
        ("camera.jitter=0.15", "encoding.variable_rate=true"),
    ),
    Condition(
        "copies",
        "every 30th or 5th picture shown twice",
        ("encoding.repeat_every=30",),
        ("encoding.repeat_every=5",),
    ),
    Condition(
        "lost",
        "every 40th or 15th picture lost, a copy of the one before in its place",
        ("encoding.repeat_every=40", "encoding.repeat_lost=true"),
        ("encoding.repeat_every=15", "encoding.repeat_lost=true"),
    ),
    Condition(
        "ramp",
        "a slow-motion export whose rate is 2 or 4 times as high where collisions are dense",
        ("clip.ramp=2", "clip.lead_frames=48", "clip.tail_frames=80"),
        ("clip.ramp=4", "clip.lead_frames=96", "clip.tail_frames=160", "clip.max_frames=900"),
    ),
)

PART = (
    Condition(
        "swing",
        "the clip runs on until the cylinder has turned round, or strikes a second time",
        ("clip.end=turn", "clip.tail_frames=60", "clip.max_frames=900"),
        ("clip.end=all", "clip.max_frames=1200"),
    ),
    Condition(
        "first_frame",
        "the cylinder swings already when the clip starts, 10 or 4 frames before it strikes",
        ("clip.lead_frames=10",),
        ("clip.lead_frames=4",),
    ),
    Condition(
        "late",
        "the clip starts after the middle or just before the second collision: not to be counted",
        ("clip.start=middle", "clip.lead_frames=0"),
        ("clip.start=second", "clip.lead_frames=1"),
    ),
    Condition(
        "early",
        "the clip ends after the middle or the last collision but one: not to be counted",
        ("clip.end=middle", "clip.tail_frames=1"),
        ("clip.end=penultimate", "clip.tail_frames=1"),
    ),
    Condition(
        "nothing",
        "nothing moves: not to be counted",
        ("clip.start=release", "clip.lead_frames=130", "clip.frames=120"),
        (
            "clip.start=release",
            "clip.lead_frames=130",
            "clip.frames=120",
            "camera.read_noise=6",
            "light.flicker_amplitude=0.1",
            "tripod.shake_px=1",
        ),
    ),
)
