"""The result of one clip: what was found, as records, arrays, text, pictures and files."""

from __future__ import annotations

import html
from dataclasses import dataclass, replace
from functools import cached_property
from os import PathLike, fspath
from pathlib import Path
from typing import TYPE_CHECKING, get_args

import numpy as np
from numpy.typing import NDArray

from count_video.answers import Followed
from count_video.corrections import reviewed
from count_video.errors import CountVideoError, UsageError, reason_of
from count_video.inputs import Signature, signature
from count_video.planning.comparison import compared
from count_video.planning.plan import Plan
from count_video.planning.request import PlanRequest, read_request
from count_video.process import shortage_explained
from count_video.progress import NO_PROGRESS, Progress
from count_video.records import Collision, Estimate, Track, TrialResult
from count_video.reports.exports import collisions_array, json_object, track_array
from count_video.reports.text import headline, result_text
from count_video.settings import CsvDialect, EvidenceSettings, PictureFormat, Shape

if TYPE_CHECKING:
    from matplotlib.figure import Figure

AnyPath = str | PathLike[str]


@dataclass(frozen=True, eq=False)
class Result:
    """The answer for one clip, and what it rests on.

    In a notebook it shows itself: the count, the text and the picture.
    """

    followed: Followed
    """The answer, and the motion that it rests on."""
    error: CountVideoError | OSError | None = None
    """Why the clip could not be read; None for every other clip, counted or not."""
    signature: Signature = ()
    """What the file system said of the clip that was counted; empty if unknown."""

    @property
    def answer(self) -> TrialResult:
        """Everything that was found, as one frozen record with a unit on every field."""
        return self.followed.result

    @property
    def clip(self) -> str:
        """The clip's path as it was given."""
        return self.answer.clip

    @property
    def count(self) -> int | None:
        """Collisions from the first touch until the cylinder turns back; None if not counted."""
        return self.answer.count

    @property
    def probability(self) -> dict[int, float]:
        """Probability of each count that comes into question; empty if none does."""
        return dict(self.answer.probability)

    @property
    def reasons(self) -> tuple[str, ...]:
        """Why the clip is not counted, or what is doubtful about the count; then the warnings."""
        why = () if self.answer.reason is None else (self.answer.reason,)
        return (*why, *self.answer.warnings)

    @property
    def what_to_do(self) -> str | None:
        """What a person can do about what leaves the count open; None if nothing does."""
        return self.answer.what_to_do

    @property
    def collisions(self) -> tuple[Collision, ...]:
        """All collisions found, in order of time; those of the count come first."""
        return self.answer.collisions

    @property
    def track(self) -> Track | None:
        """Where the bodies were in every frame, in px; None where none could be followed."""
        return self.followed.track

    @property
    def mass_ratio(self) -> Estimate | None:
        """Heavy over light mass, with an uncertainty of 0 if the masses were given."""
        return self.answer.ratio

    @property
    def pi_bounds(self) -> tuple[float, float] | None:
        """Lower and upper bound on pi by the count and the mass ratio; None where not known."""
        low, high = self.answer.pi_low, self.answer.pi_high
        return None if low is None or high is None else (low, high)

    def to_dict(self) -> dict[str, object]:
        """Return the JSON object that ``count-video --json`` prints."""
        return json_object(self.answer)

    def collisions_table(self) -> NDArray[np.void]:
        """Return a structured array, shape (collisions,), with the columns of ``collisions.csv``.

        ``pandas.DataFrame(result.collisions_table())`` takes it. What is not known is NaN.
        """
        return collisions_array(self.answer)

    def track_table(self) -> NDArray[np.void]:
        """Return a structured array, shape (frames,), with the columns of ``track.csv``.

        Empty where no bodies could be followed. The file puts the cylinder's face where the ball is
        seen to touch it, as the picture does; here it is a fixed distance from there, as tracked.
        """
        return track_array(self.track, self.answer)

    def text(self, width: int = 80) -> str:
        """Return the text that ``count-video`` prints, wrapped at ``width`` columns."""
        return result_text(self.answer, width)

    def reviewed(self, corrections: AnyPath) -> Result:
        """Return the result with a person's corrections, saved from the page, laid over it.

        UsageError if they cannot be read, or do not belong to this clip.
        """
        return self._answered(reviewed(self.answer, Path(corrections)))

    def compared(self, planned: Plan | PlanRequest | AnyPath) -> Result:
        """Return the result with a comparison with a plan, or with the ``plan.json`` of one.

        UsageError if the file holds no plan.
        """
        if isinstance(planned, str | PathLike):
            request = read_request(Path(planned))
        else:
            request = planned if isinstance(planned, PlanRequest) else planned.request
        return self._answered(compared(self.answer, request))

    def figure(self) -> Figure:
        """Draw the picture of the trial; the clip is read once more for it.

        CountVideoError if no bodies could be followed, so that there is nothing to draw, or if the
        clip changed since it was counted.
        """
        from count_video.evidence import draw_trial  # noqa: PLC0415

        self._check_clip()
        drawn = draw_trial(self.followed)
        self._check_clip()
        if drawn is None:
            raise CountVideoError(f"{self.clip}: nothing to draw: {'; '.join(self.reasons)}")
        return drawn

    def save(
        self,
        folder: AnyPath,
        *,
        picture_format: PictureFormat = "png",
        csv_dialect: CsvDialect = "comma",
        presenter: Shape | None = None,
        progress: Progress = NO_PROGRESS,
    ) -> list[Path]:
        """Write page, picture, annotated clip, tables and JSON object into a folder.

        The folder is made if it is not there, and the files, whose paths are returned, are named
        after the clip.

        Parameters
        ----------
        picture_format
            Kind of the picture.
        csv_dialect
            ``"semicolon"`` for tables with semicolons and decimal commas.
        presenter
            Shape of a clip for a talk, in full HD with a big counter, and its GIF; None: none.
        progress
            Informed of how far the drawing has come; see ``count_video.progress.Progress``.

        Raises
        ------
        UsageError
            If a file cannot be written, or would replace one that this program did not write; if
            the clip changed since it was counted.
        """
        for name, value, known in (
            ("picture_format", picture_format, get_args(PictureFormat)),
            ("csv_dialect", csv_dialect, get_args(CsvDialect)),
            ("presenter", presenter, (None, *get_args(Shape))),
        ):
            if value not in known:
                raise UsageError(f"{name} is {value!r}; it must be one of {known}")
        wanted = EvidenceSettings(Path(folder), picture_format, csv_dialect, presenter)
        return self.write(wanted, progress)

    def write(self, wanted: EvidenceSettings, progress: Progress = NO_PROGRESS) -> list[Path]:
        """Write the files as :meth:`save` does, which says what it raises."""
        from count_video.evidence import draw_evidence  # noqa: PLC0415

        self._check_clip()
        try:
            with shortage_explained():
                names = draw_evidence(self.followed, wanted, progress, with_json=True)
        finally:
            progress.finish()
        self._check_clip()
        return [wanted.folder / name for name in names]

    def _check_clip(self) -> None:
        """Raise UsageError if the clip is another than the one counted: its pictures are too."""
        before, now = (one[:2] for one in (self.signature, signature(Path(self.clip))))
        if before and now and now != before:  # empty if it is gone, which the drawing says
            raise UsageError(f"{self.clip}: the clip changed since it was counted; count it again")

    def __repr__(self) -> str:
        """One line: the clip and its count."""
        return f"<count_video.Result {headline(self.answer)}>"

    def _repr_html_(self) -> str:
        """Show the count, the picture and the text in a notebook."""
        return "\n".join(
            (
                f"<strong>{html.escape(headline(self.answer))}</strong>",
                *self._image,
                f"<pre>{html.escape(self.text())}</pre>",
            )
        )

    def _answered(self, answer: TrialResult) -> Result:
        """Return the same motion with another answer."""
        return replace(self, followed=replace(self.followed, result=answer))

    @cached_property
    def _image(self) -> tuple[str, ...]:
        """The picture in HTML, drawn once; none where nothing can be drawn any more."""
        if self.track is None:
            return ()
        from count_video.reports.drawing import picture_bytes  # noqa: PLC0415
        from count_video.reports.page import data_address  # noqa: PLC0415

        try:
            address = data_address(picture_bytes(self.figure(), "png"), "image/png")
        except (CountVideoError, OSError):
            return ()
        return (f'<img alt="Picture of the trial" style="max-width: 100%" src="{address}">',)


def refused(clip: AnyPath, error: CountVideoError | OSError) -> Result:
    """Make the result of a clip that could not be worked on."""
    return Result(Followed(TrialResult(fspath(clip), "not_counted", reason_of(error, clip))), error)
