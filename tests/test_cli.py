import os
import subprocess
import sys
from collections.abc import Callable
from pathlib import Path

import pytest

from command_line import Command
from lpslam.errors import UserError
from lpslam.mapfile.language_map import LanguageMap
from lpslam.simulation.writer import refuse_recording

pytestmark = pytest.mark.slow

CONTROL = "\x1b]0;pwned\x07[red]SA\u202eLE[/red]\x9b2J"


def widest(text: str) -> int:
    from rich.cells import cell_len

    return max(map(cell_len, text.splitlines()))


def copy_of(world: LanguageMap, folder: Path) -> Path:
    world.save(folder / "copy.lpmap")
    return folder / "copy.lpmap"


def test_a_demonstration_too_short_to_be_scored_is_told_before_it_begins(lpslam: Command, tmp_path: Path) -> None:
    assert "--frames" in lpslam("demo", "-o", tmp_path / "demo", "--frames", 2).complaint
    assert not (tmp_path / "demo").exists()


def test_help_and_version(lpslam: Command) -> None:
    shown = lpslam("--help")
    assert shown.code == 0
    assert widest(shown.out) <= 80
    for name in ("run", "calibrate", "distill", "ask", "info", "export", "draw", "eval", "simulate", "demo"):
        assert name in shown.out
        assert widest(lpslam(name, "--help").out) <= 80
    assert lpslam("--version").out.startswith("lpslam 0.")
    assert lpslam("fly").code == 2


@pytest.mark.parametrize(
    ("words", "said"),
    [
        ("run rec -o map.lpmap --max-frames 0", "'--max-frames'"),
        ("run rec -o map.lpmap --from abc", "'--from'"),
        ("serve map.lpmap --port 65536", "'--port'"),
        ("correct map.lpmap --judge maybe", "'--judge'"),
        ("run", "missing argument 'SOURCE'"),
        ("run rec more", "unexpected extra argument"),
        ("run rec --nope", "no such option: --nope"),
        ("info map.lpmap --js\non", "no such option: --js"),
    ],
)
def test_a_mistake_in_the_words_is_one_line_with_the_remedy(lpslam: Command, words: str, said: str) -> None:
    complaint = lpslam(*words.split(" ")).complaint
    assert said in complaint
    assert complaint.endswith(f"see 'lpslam {words.split()[0]} --help'")


def test_without_a_command_all_are_listed(lpslam: Command) -> None:
    done = lpslam()
    assert done.code == 2
    assert "calibrate" in done.out
    assert lpslam("bogus").complaint == "no such command 'bogus'; see 'lpslam --help'"


def test_run_says_what_it_made_and_info_says_the_same(
    lpslam: Command, clip: Callable[[int], Path], tmp_path: Path
) -> None:
    path = tmp_path / "clip.lpmap"
    made = lpslam("run", clip(14), "-o", path, "--max-frames", 12, "--sequential", "--json").json
    assert (made["frames"], made["frames_tracked"], made["frames_skipped"]) == (12, 12, 0)
    assert made["frames_read"] >= 3
    assert 0.1 < made["path_length_m"] < 2.0
    known = lpslam("info", path, "--json").json
    assert {key: known[key] for key in made} == made
    assert len(known["landmarks"]) == made["landmark_count"]
    shown = lpslam("info", path)
    assert "12, of which 12 tracked" in shown.out
    assert "not yet" in shown.out
    assert shown.err == ""


def test_without_text_nothing_is_read(lpslam: Command, clip: Callable[[int], Path], tmp_path: Path) -> None:
    made = lpslam("run", clip(5), "-o", tmp_path / "clip.lpmap", "--no-text", "--json").json
    assert (made["frames_tracked"], made["frames_read"], made["landmark_count"]) == (5, 0, 0)
    asked = lpslam("ask", tmp_path / "clip.lpmap", "Where can I eat pizza?")
    assert asked.code == 0
    assert asked.out.startswith("Nothing in this map serves that")
    assert "No text is in" in lpslam("distill", tmp_path / "clip.lpmap").out
    assert lpslam("distill", tmp_path / "clip.lpmap", "--json").json == {"landmarks": []}
    for words in ([], ["--memory"]):
        assert lpslam("draw", tmp_path / "clip.lpmap", tmp_path / "map.png", *words).code == 0


@pytest.mark.usefixtures("read_anew")
def test_two_sequential_runs_make_the_same_map_and_reading_beside_tracking_tracks_the_same(
    lpslam: Command, clip: Callable[[int], Path], tmp_path: Path
) -> None:
    from lpslam.mapfile.container import read_map_file

    recording = clip(8)
    instep, _ = (
        lpslam("run", recording, "-o", tmp_path / f"{name}.lpmap", "--sequential", "--json").json for name in ("a", "b")
    )
    a, b = (read_map_file(tmp_path / f"{name}.lpmap") for name in ("a", "b"))
    assert a.arrays.keys() == b.arrays.keys()
    assert all(a.arrays[name].tobytes() == b.arrays[name].tobytes() for name in a.arrays)
    assert a.documents.keys() == b.documents.keys()
    assert all(a.documents[name] == b.documents[name] for name in a.documents if name != "run")
    measured = {"seconds", "seconds_tracking_and_mapping"}
    measured |= {"detection_ms", "recognition_ms", "mapping_ms", "second_look_ms", "reader_processor_ms"}
    counts = [
        {key: value for part in each.documents["run"]["statistics"].values() for key, value in part.items()}
        for each in (a, b)
    ]
    assert {key for key in counts[0] if counts[0][key] != counts[1][key]} <= measured
    # Beside tracking what is left out is counted.
    beside = lpslam("run", recording, "-o", tmp_path / "beside.lpmap", "--json").json
    assert beside["frames_tracked"] == 8
    # Beside tracking, new text is noticed later, so that fewer frames are asked for.
    assert beside["frames_read"] > 0
    assert beside["frames_read"] + beside["frames_unread_for_lack_of_time"] <= instep["frames_read"]
    maps = [LanguageMap.load(tmp_path / f"{name}.lpmap") for name in ("beside", "a")]
    assert maps[0].frame_poses().world_from_camera.tobytes() == maps[1].frame_poses().world_from_camera.tobytes()


def test_distill_keeps_its_judgements_and_ask_finds_the_place(
    lpslam: Command, world: LanguageMap, tmp_path: Path
) -> None:
    path = copy_of(world, tmp_path)
    shown = lpslam("distill", path)
    assert shown.err == ""
    assert widest(shown.out) <= 80
    assert shown.out.rstrip().endswith("┘"), "the table is whole"
    judged = lpslam("info", path, "--json").json
    assert judged["question"] == "Is this a shop?"
    assert {mark["is_landmark"] for mark in judged["landmarks"]} == {True, False}
    again = lpslam("distill", path, "--judge", "Is this a warning?", "--json").json
    assert {len(mark["judgements"]) for mark in again["landmarks"]} == {2}
    answer = lpslam("ask", path, "Where is the washroom?", "--json").json
    assert "洗手间" in answer["landmark"]["name"]
    assert 0 < answer["distance"] < 20
    text = lpslam("ask", path, "Where is the washroom?").out
    assert text.startswith(f"{answer['landmark']['name']} at (")
    assert "because: " in text


def test_a_language_model_that_is_down_is_replaced_and_the_user_told(
    lpslam: Command, world: LanguageMap, tmp_path: Path
) -> None:
    path, down = copy_of(world, tmp_path), "http://127.0.0.1:9/v1#m"
    config = tmp_path / "quick.yaml"
    config.write_text("language: {attempts: 1, timeout_s: 2}\n")
    told = lpslam("distill", path, "--llm", down, "--config", config)
    assert told.code == 0
    assert "names are not by http://127.0.0.1:9/v1#m but by offline" in told.err
    assert "judgements are not by" in told.err
    assert "cannot be reached" in told.err
    asked = lpslam("ask", path, "Where is the washroom?", "--llm", down, "--config", config)
    assert "洗手间" in asked.out
    assert "cannot be reached" in asked.out
    assert "not by" not in lpslam("distill", path).err


def test_draw_export_and_eval_print_json_and_write_their_files(
    lpslam: Command, walked: Path, walk: Path, tmp_path: Path
) -> None:
    for words in (["map.png"], ["memory.png", "--memory"], ["map.svg"]):
        done = lpslam("draw", walked, tmp_path / words[0], *words[1:], "--json").json
        assert done == {"written": [str(tmp_path / words[0])]}
        assert (tmp_path / words[0]).stat().st_size > 10_000
    written = lpslam("export", walked, tmp_path / "out", "--json").json["written"]
    assert [Path(path).name for path in written] == ["trajectory.txt", "keyframes.txt", "landmarks.json", "cloud.ply"]
    assert all(Path(path).stat().st_size > 0 for path in written)
    scores = lpslam("eval", walked, walk, "--json").json
    assert scores["share_tracked"] == 1.0
    shown = lpslam("eval", walked, walk)
    assert f"{scores['ate_rmse_m']:.4f} m" in shown.out
    assert widest(shown.out) <= 80


def test_names_from_the_world_cannot_steer_the_terminal(lpslam: Command, world: LanguageMap, tmp_path: Path) -> None:
    from lpslam.language.model import Naming

    victim = next(each for each in world.text.long_term if "洗手间" in each.variants)
    victim.naming = Naming(CONTROL, 1.0, CONTROL, CONTROL)
    world.source = CONTROL
    path = copy_of(world, tmp_path)
    outputs = [lpslam("info", path), lpslam("distill", path)]
    for done in outputs:
        assert done.code == 0
        assert not {"\x1b", "\x07", "\x9b", "\u202e"} & set(done.out + done.err)
    assert "[red]SALE[/red]" in outputs[0].out, "no markup is taken away either"


def test_a_terminal_without_chinese_shows_numbers_and_no_traceback(walked: Path) -> None:
    script = "from lpslam.cli import main; main()"
    environment = {**os.environ, "PYTHONIOENCODING": "ascii"}
    for words in (["info", walked], ["info", walked, "--json"]):
        done = subprocess.run([sys.executable, "-c", script, *words], capture_output=True, env=environment, check=True)
        assert b"\\u6d17" in done.stdout
        assert done.stderr == b""


def test_a_terminal_that_does_not_know_its_width_is_told_all_the_same(
    lpslam: Command, walked: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    whole = lpslam("info", walked).out
    monkeypatch.setenv("COLUMNS", "0")
    assert lpslam("info", walked).out == whole != ""


def test_a_map_of_a_recording_whose_name_is_no_text_can_be_read_again(world: LanguageMap, tmp_path: Path) -> None:
    world.source = os.fsdecode(b"walk\xff")
    assert LanguageMap.load(copy_of(world, tmp_path)).source == "walk?"


def test_simulate_writes_a_recording_but_not_over_one_that_was_recorded(
    lpslam: Command, clip: Callable[[int], Path], tmp_path: Path
) -> None:
    done = lpslam("simulate", tmp_path / "mall", "--frames", 2, "--seed", 3, "--json").json
    assert done["frames"] == 2
    assert (tmp_path / "mall" / "groundtruth.txt").is_file()
    with pytest.raises(UserError, match="not empty"):
        refuse_recording(tmp_path / "mall")
    recorded = clip(2)
    (recorded / "signs.json").unlink()
    assert "is not overwritten" in lpslam("simulate", recorded, "--frames", 1).complaint


def test_config_prints_what_config_takes(lpslam: Command, tmp_path: Path) -> None:
    from lpslam.config import Config

    (tmp_path / "all.yaml").write_text(lpslam("config").out, encoding="utf-8")
    assert Config.from_yaml(tmp_path / "all.yaml") == Config()
