"""What ``import count_video`` offers: the answers of the command, for programs and notebooks."""

from __future__ import annotations

import csv
import json
import math
import pickle
import shutil
import subprocess
import sys
from fractions import Fraction
from pathlib import Path

import numpy as np
import pytest

import count_video
from count_video import CountVideoError, FootageError, Result, UsageError, cli, pipeline
from count_video.progress import Progress
from count_video.settings import trial_settings

FIXTURES = Path(__file__).parents[2] / "fixtures"
CLIP = FIXTURES / "ratio1-count3.mp4"
"""The shortest of the clips; its truth is three collisions."""
ROUNDED = {"rtol": 0, "atol": 0.51e-2}
"""CSV files have at least two decimals of every number."""


@pytest.fixture(scope="session")
def result() -> Result:
    return count_video.count(CLIP, masses=(1.05, 1.05), capture_fps=240)


@pytest.fixture(scope="session")
def saved(result: Result, tmp_path_factory: pytest.TempPathFactory) -> list[Path]:
    return result.save(tmp_path_factory.mktemp("saved") / "evidence")


def test_a_clip_is_counted(result: Result) -> None:
    assert result.count == 3
    assert result.clip == str(CLIP)
    assert sum(result.probability.values()) == pytest.approx(1, abs=1e-9)
    assert max(result.probability, key=result.probability.__getitem__) == 3
    assert result.reasons == ()
    assert result.error is None
    assert repr(result) == "<count_video.Result ratio1-count3.mp4: 3 collisions>"


@pytest.fixture
def counted_once(result: Result, monkeypatch: pytest.MonkeyPatch) -> None:
    """Give the answer for the clip without another count."""
    monkeypatch.setattr(pipeline, "work_through", lambda *_: result.followed)


@pytest.mark.usefixtures("counted_once")
def test_no_evidence_shows_another_clip_than_the_one_counted(tmp_path: Path) -> None:
    clip = tmp_path / "clip.mp4"
    shutil.copy(CLIP, clip)
    result = count_video.count(clip)
    shutil.copy(FIXTURES / "ratio16-count12.mp4", clip)
    with pytest.raises(UsageError, match="changed since it was counted"):
        result.save(tmp_path / "evidence")
    assert not (tmp_path / "evidence").exists()
    with pytest.raises(UsageError, match="changed since it was counted"):
        result.figure()
    assert "<img" not in result._repr_html_()  # the count alone
    clip.unlink()
    assert "3 collisions" in result._repr_html_()


@pytest.mark.parametrize(
    "wrong", [{"picture_format": "jpg"}, {"csv_dialect": "tab"}, {"presenter": "square"}]
)
def test_a_format_that_there_is_not_is_refused_before_anything_is_written(
    result: Result, tmp_path: Path, wrong: dict[str, str]
) -> None:
    with pytest.raises(UsageError, match=f"{next(iter(wrong))} is '"):
        result.save(tmp_path / "evidence", **wrong)  # type: ignore[arg-type]
    assert not (tmp_path / "evidence").exists()


def test_masses_are_taken_at_their_decimal_values(result: Result) -> None:
    assert result.mass_ratio == count_video.records.Estimate(1.0, 0.0)
    assert result.pi_bounds == pytest.approx((3 * math.pi / 4, math.pi), abs=1e-12)
    assert trial_settings(masses=(1.05, "0.0105")).masses == (
        Fraction(105, 100),
        Fraction(21, 2000),
    )


@pytest.mark.usefixtures("counted_once")
def test_the_dictionary_is_the_json_object_of_the_command(
    result: Result, capsys: pytest.CaptureFixture[str]
) -> None:
    arguments = ["--json", str(CLIP), "--masses", "1.05", "1.05", "--capture-fps", "240"]
    assert cli.main(arguments) == 0
    assert json.loads(capsys.readouterr().out) == result.to_dict()


@pytest.mark.usefixtures("counted_once")
def test_the_text_is_that_of_the_command(
    result: Result, capsys: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.delenv("COLUMNS", raising=False)
    assert cli.main([str(CLIP), "--masses", "1.05", "1.05", "--capture-fps", "240"]) == 0
    assert capsys.readouterr().out == f"{result.text()}\n"


@pytest.mark.parametrize("name", ["collisions", "track"])
def test_a_table_has_the_columns_and_the_values_of_its_file(
    result: Result, saved: list[Path], name: str
) -> None:
    table = getattr(result, f"{name}_table")()
    (file,) = [file for file in saved if file.name == f"{CLIP.stem}.{name}.csv"]
    rows = list(csv.DictReader(file.read_text("utf-8").splitlines()))
    assert table.dtype.names == tuple(rows[0])
    assert len(table) == len(rows)
    for column in table.dtype.names:
        cells = [row[column] for row in rows]
        if table[column].dtype.kind == "f":
            numbers = np.array([float(cell or "nan") for cell in cells])
            if column in ("heavy_px", "heavy_mm"):  # the file has the face where the ball touches
                numbers -= np.median(numbers - table[column])
            np.testing.assert_allclose(table[column], numbers, **ROUNDED)
        elif table[column].dtype.kind == "b":
            assert [("no", "yes")[int(value)] for value in table[column]] == cells
        else:
            assert [str(value) for value in table[column]] == cells


def test_the_files_are_saved_beside_each_other_and_named(saved: list[Path]) -> None:
    suffixes = ("annotated.mp4", "collisions.csv", "html", "json", "png", "strip.jpg", "track.csv")
    panels = ("energy", "phase-circle", "space-time", "velocities")
    names = sorted([*suffixes, *(f"{panel}.png" for panel in panels)])
    assert sorted(file.name for file in saved) == [f"{CLIP.stem}.{end}" for end in names]
    assert all(file.stat().st_size for file in saved)


def test_a_saved_result_reads_back_as_the_json_object(result: Result, saved: list[Path]) -> None:
    (file,) = [file for file in saved if file.suffix == ".json"]
    assert json.loads(file.read_text("ascii")) == result.to_dict()


def test_a_file_of_somebody_else_is_not_replaced(result: Result, tmp_path: Path) -> None:
    page = tmp_path / f"{CLIP.stem}.html"
    page.write_text("mine", "utf-8")
    with pytest.raises(UsageError, match="not written by this program"):
        result.save(tmp_path)
    assert [file.name for file in tmp_path.iterdir() if file.suffix] == [page.name]
    assert page.read_text("utf-8") == "mine"


def test_a_notebook_shows_the_count_and_the_picture(result: Result) -> None:
    shown = result._repr_html_()
    assert "<strong>ratio1-count3.mp4: 3 collisions</strong>" in shown
    assert 'src="data:image/png;base64,iVBOR' in shown  # how every PNG begins


def test_the_figure_has_a_panel_with_every_collision(result: Result) -> None:
    figure = result.figure()
    assert len(figure.axes) >= 4
    assert {text.get_text() for axes in figure.axes for text in axes.texts} >= {"1", "2", "3"}


def test_a_clip_that_supports_no_count_says_why() -> None:
    short = count_video.count(CLIP, end=5)
    assert short.count is None
    assert short.probability == {}
    assert len(short.reasons) >= 1
    assert short.reasons[0] in short._repr_html_()
    if short.track is None:
        assert short.track_table().shape == (0,)
        with pytest.raises(CountVideoError, match="nothing to draw"):
            short.figure()


def test_a_file_that_cannot_be_read_is_an_error(tmp_path: Path) -> None:
    with pytest.raises(FootageError, match="no such file"):
        count_video.count(tmp_path / "missing.mp4")


def test_an_address_on_the_web_is_no_file() -> None:
    with pytest.raises(FootageError, match="address on the web; download it"):
        count_video.count(Path("https://example.org/clip.mp4"))


@pytest.mark.parametrize(
    ("settings", "words"),
    [
        ({"masses": (1, 100)}, "cylinder first"),
        ({"masses": (100, 0)}, "masses: '0'"),
        ({"masses": (100,)}, "two masses"),
        ({"masses": "91"}, "two masses"),
        ({"masses": 16}, "two masses"),
        ({"masses": ("heavy", 1)}, "masses: 'heavy'"),
        ({"capture_fps": math.nan}, "capture_fps: 'nan'"),
        ({"region": (1, 2, 3)}, "region: '1,2,3'"),
        ({"region": "1,2,3"}, "region: '1,2,3'"),
        ({"wall": "up"}, "wall: 'up'"),
        ({"start": 5, "end": 5}, "no frame"),
        ({"start": -1}, "start: '-1'"),
        ({"ball_diameter_mm": 0}, "ball_diameter_mm: '0'"),
        ({"colour": "red"}, "no setting colour"),
    ],
)
def test_a_value_that_makes_no_sense_is_refused_by_its_name(
    settings: dict[str, object], words: str
) -> None:
    with pytest.raises(UsageError, match=words):
        trial_settings(**settings)  # type: ignore[arg-type]


def test_the_progress_is_ended_also_where_the_count_fails(tmp_path: Path) -> None:
    class Recorder(Progress):
        ended = 0

        def start(self, total: int | None, label: str) -> None: ...

        def advance(self, frames: int) -> None: ...

        def finish(self) -> None:
            self.ended += 1

    recorder = Recorder()
    progress: Progress = recorder
    with pytest.raises(FootageError):
        count_video.count(tmp_path / "missing.mp4", progress=progress)
    assert recorder.ended >= 1


def test_all_frames_are_reported_as_done() -> None:
    class Recorder(Progress):
        total, done = 0, 0

        def start(self, total: int | None, label: str) -> None:
            self.total = total or 0

        def advance(self, frames: int) -> None:
            self.done += frames

    recorder = Recorder()
    count_video.count(CLIP, start=3, progress=recorder)
    assert recorder.done == recorder.total > 0


@pytest.mark.parametrize(
    "details",
    [{"gap_m": 1j}, {"gap_m": "wide"}, {"tolerances": None}, {"colour": "red"}, {"trials": 2.5}],
)
def test_what_a_plan_cannot_be_made_of_is_refused(details: dict[str, object]) -> None:
    with pytest.raises(UsageError, match=next(iter(details))):
        count_video.plan(100, 1, chart=False, **details)  # type: ignore[arg-type]


def test_a_plan_takes_masses_at_their_decimal_values() -> None:
    plan = count_video.plan(0.9, 0.3, gap_m=np.float32(0.03), chart=False)  # type: ignore[arg-type]
    assert plan.burst.theory == count_video.theory(0.9, 0.3).count == 5


def test_the_theory_is_exact_also_where_a_float_is_not() -> None:
    assert count_video.theory(1050, 10.5).count == 31
    # At 1:1 the count is 3, and 4 for the least bit more; 0.3 / 0.1 is more than 3 in floats.
    assert count_video.theory(0.3, 0.1) == count_video.theory(3, 1)
    found = count_video.theory(1)
    assert found.count == 3
    assert found.pi_bounds == pytest.approx((3 * math.pi / 4, math.pi), abs=1e-12)
    assert found.same_count[0] < found.mass_ratio <= found.same_count[1]


def test_many_clips_come_each_with_its_own_result(result: Result, tmp_path: Path) -> None:
    missing, empty = tmp_path / "missing.mp4", tmp_path / "empty.mp4"
    empty.touch()
    found = count_video.count_all([CLIP, missing, empty], masses=(1.05, 1.05), capture_fps=240)
    results = {Path(one.clip).name: one for one in found}
    assert sorted(results) == sorted(clip.name for clip in (CLIP, missing, empty))
    assert isinstance(results["missing.mp4"].error, FootageError)
    assert results["missing.mp4"].reasons == ("no such file; check the name",)
    assert results[CLIP.name].to_dict() == result.to_dict()
    together, alone = results[CLIP.name].track_table(), result.track_table()
    assert len(together) > 0
    np.testing.assert_array_equal(together["heavy_px"], alone["heavy_px"])


def test_a_setting_that_makes_no_sense_counts_nothing(tmp_path: Path) -> None:
    with pytest.raises(UsageError, match="wall"):
        next(count_video.count_all(tmp_path, wall="up"))  # type: ignore[arg-type]


def test_masses_and_a_region_may_be_arrays() -> None:
    settings = trial_settings(masses=np.array([16, 1]), region=np.array([0, 2, 64, 32]))  # type: ignore[arg-type]
    assert settings.masses == (16, 1)
    assert settings.region == (0, 2, 64, 32)
    rate = np.array(240.0)  # of no dimension
    assert trial_settings(capture_fps=rate).capture_fps == 240.0  # type: ignore[arg-type]


@pytest.mark.parametrize("jobs", [0, -3, 1.5])
def test_a_number_of_jobs_that_makes_no_sense_is_refused(tmp_path: Path, jobs: float) -> None:
    with pytest.raises(UsageError, match=f"jobs: '{jobs}'"):
        next(count_video.count_all(tmp_path, jobs=jobs))  # type: ignore[arg-type]


def test_a_start_beyond_the_clip_says_how_long_it_is() -> None:
    with pytest.raises(UsageError, match="which has 108 frames"):
        count_video.count(CLIP, start=100_000)


def test_a_wall_that_the_motion_contradicts_is_a_warning() -> None:
    right, left = count_video.count(CLIP, wall="right"), count_video.count(CLIP, wall="left")

    assert any("--wall" in warning for warning in right.answer.warnings)
    assert not any("--wall" in warning for warning in left.answer.warnings)


def test_a_folder_without_clips_is_one_result_that_says_so(tmp_path: Path) -> None:
    (only,) = count_video.count_all(tmp_path)
    assert "no video file" in only.reasons[0]
    assert only.count is None


def test_a_result_can_be_kept_and_read_again(result: Result) -> None:
    again = pickle.loads(pickle.dumps(result))
    assert again.to_dict() == result.to_dict()
    np.testing.assert_array_equal(again.track_table(), result.track_table())


def test_a_result_is_held_against_a_plan(result: Result, tmp_path: Path) -> None:
    planned = count_video.plan(1, 1, gap_m=0.02, chart=False, trials=2)
    comparison = result.compared(planned).answer.comparison
    assert comparison is not None
    assert comparison.planned_count == planned.burst.count


def test_everything_offered_is_there_and_nothing_heavy_is_imported_for_it() -> None:
    program = (
        "import sys, count_video; heavy = {'numpy', 'cv2', 'av', 'scipy', 'matplotlib', 'mpmath'};"
        "assert set(count_video.__all__) <= set(dir(count_video));"
        "assert not heavy & set(sys.modules), heavy & set(sys.modules);"
        "print(all(getattr(count_video, name) is not None for name in count_video.__all__))"
    )
    done = subprocess.run(
        [sys.executable, "-c", program], capture_output=True, text=True, check=True
    )
    assert done.stdout == "True\n"
    with pytest.raises(AttributeError, match="no attribute 'counted'"):
        count_video.counted  # noqa: B018


def test_type_checkers_find_that_the_package_has_types() -> None:
    assert (Path(count_video.__file__).parent / "py.typed").is_file()
