from __future__ import annotations

import sys
from fractions import Fraction
from pathlib import Path

import pytest
from hypothesis import given
from hypothesis import strategies as st

from count_video.batch.manifest import clips_in, jobs_of
from count_video.errors import FootageError, UsageError
from count_video.pipeline import TrialSettings

PLAIN = TrialSettings()


def names(*paths: str | Path) -> list[str]:
    return [job.name for job in jobs_of(map(Path, paths), PLAIN)]


def manifest(folder: Path, text: str) -> Path:
    file = folder / "list.csv"
    file.write_text(text, "utf-8")
    return file


def complaint(file: Path) -> str:
    with pytest.raises(UsageError) as caught:
        jobs_of([file], PLAIN)
    return str(caught.value)


@pytest.mark.skipif(sys.platform == "win32", reason="a folder in use cannot be removed there")
def test_a_current_folder_that_is_gone_is_reported(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    gone = tmp_path / "gone"
    gone.mkdir()
    with monkeypatch.context() as there:
        there.chdir(gone)
        gone.rmdir()
        said = complaint(tmp_path / "trial.mp4")
    assert "current folder is gone" in said


def test_a_result_is_named_after_its_clip() -> None:
    assert names("a/trial1.mp4", "trial2.MOV") == ["trial1", "trial2"]


@pytest.mark.parametrize(
    ("paths", "expected"),
    [
        (["a.mp4", "a.mov"], ["a", "a.mov"]),
        (["one/a.mp4", "two/a.mp4", "two/a.mov"], ["a", "two-a", "a.mov"]),
        (["a.mp4", "A.mp4"], ["a", "A.mp4"]),
        ([f"{k}/x/a.mp4" for k in range(4)], ["a", "x-a", "x-a.mp4", "a-2"]),
        (["campaign.mp4"], ["campaign.mp4"]),
    ],
    ids=["suffixes", "folders", "case", "folders of one name", "the campaign's own file"],
)
def test_no_two_results_have_the_same_name(paths: list[str], expected: list[str]) -> None:
    assert names(*paths) == expected


def test_a_folder_without_a_clip_is_a_job_with_its_problem(tmp_path: Path) -> None:
    (job,) = jobs_of([tmp_path], PLAIN)
    assert "no video file in this folder" in (job.problem or "")


def test_a_folder_that_may_not_be_read_says_so(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    def forbidden(_: Path) -> None:
        raise PermissionError(13, "Permission denied")

    monkeypatch.setattr(Path, "iterdir", forbidden)
    (job,) = jobs_of([tmp_path], PLAIN)
    assert job.problem == "this folder cannot be read (Permission denied); check its rights"


def test_a_manifest_gives_each_clip_its_options(tmp_path: Path) -> None:
    file = manifest(
        tmp_path,
        "clip,name,region,masses,wall,capture_fps,start,end,ball_diameter_mm\n"
        'a.mp4,first,"1,2,30,40",1050 10.5,left,960,3,9,20\n'
        "sub/b.mp4,,,,,,,,\n",
    )
    first, second = jobs_of([file], TrialSettings(capture_fps=240.0))
    assert (first.name, first.clip) == ("first", str(tmp_path / "a.mp4"))
    assert first.settings == TrialSettings(
        capture_fps=960.0,
        ball_diameter_mm=20.0,
        wall="left",
        region=(1, 2, 30, 40),
        start=3,
        end=9,
        masses=(Fraction(1050), Fraction(21, 2)),
    )
    assert (second.name, second.clip) == ("b", str(tmp_path / "sub" / "b.mp4"))
    assert second.settings == TrialSettings(capture_fps=240.0), "empty cells leave the options"


def test_the_manifest_in_a_folder_is_heeded_and_no_clip_is_left_out(tmp_path: Path) -> None:
    for name in ("a.mp4", "b.mp4", "c.mp4"):
        (tmp_path / name).touch()
    manifest(tmp_path, "clip,capture_fps\nb.mp4,960\n").rename(tmp_path / "manifest.csv")
    jobs = jobs_of([tmp_path], PLAIN)
    assert [(job.name, job.settings.capture_fps) for job in jobs] == [
        ("b", 960.0),
        ("a", None),
        ("c", None),
    ]


def test_a_name_that_is_given_twice_is_numbered(tmp_path: Path) -> None:
    manifest = tmp_path / "list.csv"
    manifest.write_text("clip,name\na.mp4,trial A\nsub/a.mp4,trial A\n", "utf-8")

    names = [job.name for job in jobs_of([manifest], TrialSettings())]

    assert names == ["trial A", "trial A-2"]


def test_a_line_of_separators_alone_is_none(tmp_path: Path) -> None:
    file = manifest(tmp_path, "clip,capture_fps\n,,\na.mp4,960\n , \n")

    assert [job.name for job in jobs_of([file], PLAIN)] == ["a"]


def test_no_trial_is_summed_up_twice(tmp_path: Path) -> None:
    clip, file = tmp_path / "a.mp4", manifest(tmp_path, "clip,wall\na.mp4,left\na.mp4,left\n")
    clip.touch()

    for paths in ([file], [tmp_path / "." / "a.mp4", clip]):
        with pytest.raises(UsageError, match="listed twice"):
            jobs_of(paths, PLAIN)


def test_a_column_that_is_not_known_is_named(tmp_path: Path) -> None:
    manifest = tmp_path / "list.csv"
    manifest.write_text("clip,colour\na.mp4,red\n", "utf-8")

    with pytest.raises(UsageError, match="not 'colour'"):
        jobs_of([manifest], TrialSettings())


def test_a_manifest_may_cut_one_clip_into_trials(tmp_path: Path) -> None:
    file = manifest(tmp_path, "clip,start,end\nday.mp4,0,500\nday.mp4,500,900\n")
    jobs = jobs_of([file], PLAIN)
    assert [(job.name, job.settings.start) for job in jobs] == [("day", 0), ("day.mp4", 500)]


@pytest.mark.parametrize(
    "text",
    [
        "clip;masses\r\na.mp4;1050 10.5\r\n",
        "clip;masses\r\na.mp4;1050 10,5\r\n",
        "\ufeffClip , masses\na.mp4, 1050   10.5\n",
    ],
    ids=["semicolons", "decimal commas", "a spreadsheet's mark, capitals and blanks"],
)
def test_a_manifest_is_read_as_spreadsheets_write_it(tmp_path: Path, text: str) -> None:
    (job,) = jobs_of([manifest(tmp_path, text)], PLAIN)
    assert (job.name, job.settings.masses) == ("a", (Fraction(1050), Fraction(21, 2)))


@pytest.mark.parametrize(
    ("text", "words"),
    [
        ("", "the first line must name the columns"),
        ("clip\n", "names no clip"),
        ("clip,colour\na.mp4,red\n", "the first line must name the columns"),
        ("clip,clip\na.mp4,b.mp4\n", "each once"),
        ("clip,wall\na.mp4,up\n", "line 2: "),
        ("clip,region\na.mp4,1,2,3,4\n", "line 2: more cells than columns"),
        ("clip,masses\na.mp4,1050\n", "line 2: "),
        ("clip,capture_fps\na.mp4,960\nb.mp4,-5\n", "line 3: "),
        ("clip,start,end\na.mp4,9,3\n", "leaves no frame"),
        ("clip,wall\n,left\n", "line 2: no clip"),
        ("clip,name\na.mp4,../x\n", "no name for a file"),
        ('"clip,name\na.mp4,x\n', "unexpected end of data"),
        ('"clip"x,name\na.mp4,x\n', "expected after"),
        ("clip\na\0b.mp4\n", "line 2: "),
        ("clip," + "x" * 131_073 + "\na.mp4,\n", "field larger than field limit"),
    ],
)
def test_what_makes_no_sense_in_a_manifest_is_said_with_its_line(
    tmp_path: Path, text: str, words: str
) -> None:
    file = manifest(tmp_path, text)
    said = complaint(file)
    assert words in said
    assert said.startswith(str(file))
    assert "\n" not in said


def test_a_manifest_that_is_not_there_or_not_text_is_reported(tmp_path: Path) -> None:
    assert "cannot be read: No such file" in complaint(tmp_path / "missing.csv")
    (tmp_path / "picture.csv").write_bytes(b"\x89PNG\xff\xfe")
    assert "no text in UTF-8" in complaint(tmp_path / "picture.csv")


def touch(folder: Path, *names: str) -> None:
    folder.mkdir(exist_ok=True)
    for name in names:
        (folder / name).touch()


def test_a_folder_stands_for_the_video_files_in_it(tmp_path: Path) -> None:
    touch(tmp_path, "clip10.mp4", "clip2.MOV", "notes.txt", "clip1.mkv", "._clip1.mkv", "mp4")
    touch(tmp_path / "folder.mp4", "deeper.mp4")
    assert [clip.name for clip in clips_in(tmp_path)] == ["clip1.mkv", "clip2.MOV", "clip10.mp4"]


@pytest.mark.skipif(sys.platform == "win32", reason="links need rights there")
def test_a_link_that_leads_nowhere_is_not_passed_over(tmp_path: Path) -> None:
    (tmp_path / "far.mp4").symlink_to(tmp_path / "unmounted" / "clip.mp4")
    (tmp_path / "folder.mp4").mkdir()
    assert [clip.name for clip in clips_in(tmp_path)] == ["far.mp4"]


def test_a_folder_without_a_clip_is_reported(tmp_path: Path) -> None:
    touch(tmp_path, "notes.txt")
    with pytest.raises(FootageError, match="no video file in this folder"):
        clips_in(tmp_path)


@given(st.lists(st.integers(0, 10**12), min_size=1, max_size=8, unique=True))
def test_numbered_clips_come_in_the_order_of_their_numbers(
    tmp_path_factory: pytest.TempPathFactory, numbers: list[int]
) -> None:
    folder = tmp_path_factory.mktemp("numbered")
    touch(folder, *(f"Clip {number} b.mp4" for number in numbers))
    assert clips_in(folder) == [folder / f"Clip {number} b.mp4" for number in sorted(numbers)]


def test_names_that_begin_with_a_number_and_with_a_letter_can_be_ordered(tmp_path: Path) -> None:
    touch(tmp_path, "2.mp4", "b.mp4", "10.mp4", "2b.mp4", "².mp4")
    assert [clip.name for clip in clips_in(tmp_path)][:3] == ["2.mp4", "2b.mp4", "10.mp4"]
