"""The command by which a person corrects a map."""

from pathlib import Path
from typing import Annotated, Any, Literal

import typer

from lpslam.cli_checks import config_of
from lpslam.cli_options import Json
from lpslam.errors import UserError
from lpslam.views.printed import print_json, print_table, say


def correct(
    map_file: Annotated[Path, typer.Argument(metavar="MAP", help="A map made by 'lpslam run'.", show_default=False)],
    landmark: Annotated[
        int | None, typer.Argument(metavar="ID", help="Of a landmark; see 'lpslam info'.", show_default=False)
    ] = None,
    name: Annotated[str | None, typer.Option("--name", metavar="TEXT", help="What the sign says.")] = None,
    into: Annotated[int | None, typer.Option("--same-as", metavar="ID", help="It is the same as this one.")] = None,
    hide: Annotated[bool, typer.Option("--hide", help="It is nothing that anybody should be sent to.")] = False,
    judge: Annotated[
        Literal["yes", "no"] | None, typer.Option("--judge", help="By the map's current question; see 'distill'.")
    ] = None,
    undo: Annotated[int | None, typer.Option("--undo", metavar="NUMBER", help="Take a correction back.")] = None,
    as_json: Json = False,
) -> None:
    """Say what a landmark is: it wins over what was read, and is kept in the map. Without an id, list what was said."""
    from lpslam.language.registry import language_model
    from lpslam.mapfile.container import identity_of
    from lpslam.mapfile.correcting import change_corrections, editing
    from lpslam.mapfile.export import corrections_record
    from lpslam.mapfile.language_map import LanguageMap
    from lpslam.navigation.known import remember
    from lpslam.text.correcting.changing import Change, correct, take_back
    from lpslam.text.correcting.corrections import Kind

    wanted: dict[Kind, dict[str, Any]] = {}
    if name is not None:
        wanted[Kind.RENAME] = {"name": name}
    if into is not None:
        wanted[Kind.MERGE] = {"into": into}
    if hide:
        wanted[Kind.HIDE] = {}
    if judge is not None:
        wanted[Kind.JUDGE] = {"answer": judge == "yes"}
    if (landmark is None) == bool(wanted):
        raise UserError("give the id of a landmark and what it is: --name, --same-as, --hide or --judge")
    if undo is not None and wanted:
        raise UserError("--undo takes a correction back, and excludes all else")
    if wanted or undo is not None:
        language = language_model(None, config_of(None).language)

        def change(text: Any, world: LanguageMap) -> None:
            if undo is not None:
                take_back(text, undo)
            for kind, said in wanted.items():
                correct(text, world.world_from_keyframe, Change(kind, landmark or 0, **said), language)

        with editing(map_file):
            world = change_corrections(map_file, change, LanguageMap.load(map_file))
            remember(world, identity_of(map_file))
    else:
        world = LanguageMap.load(map_file)
    said = world.text.corrections
    record = corrections_record(said)
    if as_json:
        print_json({"map": str(map_file), **record})
        return
    if not said.entries:
        say(f"nothing is corrected in {map_file}")
        return
    print_table({f"{each['number']}: {each['landmark']} {each['read']}": _said(each) for each in record["corrections"]})


def _said(record: dict[str, Any]) -> str:
    """What was said, in words."""
    if "into" in record:
        return f"is the same as {record['into']} {record['into_name']}"
    if "answer" in record:
        return f"{record['question']} {'yes' if record['answer'] else 'no'}"
    return f"is called {record['name']}" if "name" in record else "is hidden"
