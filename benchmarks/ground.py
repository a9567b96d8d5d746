"""The ground against the true floor plan of rendered malls or worlds: free floor, walls, goal poses, ways.

    python benchmarks/ground.py --seeds 401-406
    python benchmarks/ground.py --worlds 1003,1009       # sheets of glass and mirrors are walls

Floor and walls are those cells that the map knows. A wall is free if no cell within ten centimetres is occupied; the
rim of the floor, as wide, is not asked. Of worlds with people the floor is told a second time without the half metre
around where somebody was when a scan was taken: who stood there last is in the way, and rightly so. Goal poses are
asked for every sign that was readable and hangs where a person could stand before it; ways between pairs of them are
compared with the shortest on the true plan for the same robot.
"""

import argparse
import time
from dataclasses import dataclass, replace
from itertools import pairwise

import cv2
import numpy as np
from numpy.typing import NDArray

from lpslam.camera import transform_points
from lpslam.config import Config, WayConfig
from lpslam.errors import UserError
from lpslam.ground.grid import FREE, OCCUPIED, Grid
from lpslam.mapfile.language_map import LanguageMap
from lpslam.navigation.walking.goals import goal_before
from lpslam.navigation.walking.ways import NoWayError, Walkable
from lpslam.session.session import Session
from lpslam.simulation.source import MallSource
from lpslam.simulation.worlds.factors import draw_world
from lpslam.simulation.worlds.source import WorldSource
from lpslam.simulation.worlds.walking import walked
from lpslam.sources.prefetch import Prefetched

Array = NDArray[np.float64]

HEIGHTS = (0.05, 1.5)  # metres between which a face is in the way
RIM = 0.1  # metres
PERSON = 0.5  # metres around somebody's middle
PAIRS = 30


Source = MallSource | WorldSource


@dataclass(frozen=True)
class Score:
    """Of one place: shares of floor that is free, also where nobody was, and of walls; goals; ways; straying; cost."""

    floor: float
    empty_floor: float
    walls: float
    goals: int
    good: int
    ways: int
    long: int
    through: int
    ratio: float
    strays: float
    cost: float


def standing(source: Source) -> Array:
    """(n, 4, 3) corners of all upright faces that never move."""
    if isinstance(source, MallSource):
        scene, panes, walkers = source.scene, (), ()
    else:
        scene, panes, walkers = source.place.scene, source.place.panes, source.place.walkers
    is_fixed = np.abs(scene.normal[:, 2]) < 0.7
    for walker in walkers:
        is_fixed[walker.first : walker.last] = False
    sheets = [(each.corner, each.edge_u, each.edge_v) for each in panes]
    faces = [*zip(scene.origin[is_fixed], scene.edge_u[is_fixed], scene.edge_v[is_fixed], strict=True), *sheets]
    return np.array([[at, at + u, at + u + v, at + v] for at, u, v in faces])


def true_plan(source: Source, low: Array, high: Array, cell: float) -> NDArray[np.bool_]:
    """Which cells (rows, columns) between two corners a face stands in."""
    columns, rows = np.ceil((high - low) / cell).astype(int)
    plan = np.zeros((rows, columns), np.uint8)
    for face in standing(source):
        if face[:, 2].min() < HEIGHTS[1] and face[:, 2].max() > HEIGHTS[0]:
            at = np.floor((face[:, :2] - low) / cell).astype(np.int32)
            cv2.polylines(plan, [at.reshape(-1, 1, 2)], True, 1)
    return plan > 0


def people(source: Source, times: Array) -> Array:
    """(n, 2) metres where somebody was at any of some times."""
    if isinstance(source, MallSource):
        return np.empty((0, 2))
    place = source.place
    scenes = [walked(place.scene, place.walkers, float(time)) for time in times]
    return np.array([
        scene.origin[who.first : who.last, :2].mean(axis=0) for scene in scenes for who in place.walkers
    ]).reshape(-1, 2)  # fmt: skip


def mapped(source: Source, config: Config) -> LanguageMap:
    """The map of a place, without reading."""
    with Session(source.camera, config, text=False, name=source.name) as session:
        for frame in Prefetched(source):
            session.take(frame)
        return session.close()


def measure(source: Source, seed: int) -> Score:
    """Map a mall or a world without reading, and compare."""
    config = Config()
    world = mapped(source, config)
    poses, truth = world.frame_poses(), source.ground_truth
    rows = np.searchsorted(truth.timestamps, poses.timestamps).clip(max=len(truth.timestamps) - 1)
    first = len(rows) // 2
    truth_from_map = truth.world_from_camera[rows[first]] @ np.linalg.inv(poses.world_from_camera[first])
    off = (truth_from_map @ poses.world_from_camera)[:, :2, 3] - truth.world_from_camera[rows, :2, 3]
    began = time.process_time()
    grid = world.grid(config.ground)
    if grid is None or world.scans is None:
        raise UserError(f"{source.name}: no floor was seen")
    cost = (time.process_time() - began) / len(world.scans)
    stood = people(source, np.array([world.slam.frame_of(each)[1] for each in world.scans.keyframes]))
    score = _score(source, grid, truth_from_map, stood, config.ways, seed)
    return replace(score, strays=float(np.linalg.norm(off, axis=1).max()), cost=cost)


def _score(source: Source, grid: Grid, truth_from_map: Array, stood: Array, ways: WayConfig, seed: int) -> Score:
    cells = np.argwhere(grid.values >= 0)
    flat = np.column_stack([grid.middles(cells), np.zeros(len(cells))])
    places = transform_points(truth_from_map, flat)[:, :2]
    low, cell = places.min(axis=0) - 1.0, grid.resolution
    plan = true_plan(source, low, places.max(axis=0) + 1.0, cell)
    away = cv2.distanceTransform((~plan).astype(np.uint8), cv2.DIST_L2, 5) * cell
    at = np.floor((places - low) / cell).astype(int)[:, ::-1]
    walked = np.floor((source.ground_truth.world_from_camera[:, :2, 3] - low) / cell).astype(int)[:, ::-1]
    _, regions = cv2.connectedComponents((~plan).astype(np.uint8), connectivity=4)
    inside = np.isin(regions, np.unique(regions[walked[:, 0], walked[:, 1]])) & ~plan
    values = grid.values[cells[:, 0], cells[:, 1]]
    is_floor = inside[at[:, 0], at[:, 1]] & (away[at[:, 0], at[:, 1]] > RIM)
    about = np.linalg.norm(places[:, None] - stood[None], axis=2).min(axis=1, initial=np.inf)
    near = cv2.dilate((grid.values == OCCUPIED).astype(np.uint8), np.ones((5, 5), np.uint8)) > 0
    is_wall = plan[at[:, 0], at[:, 1]]
    wrong = (values == FREE) & ~near[cells[:, 0], cells[:, 1]]
    walkable = Walkable(grid, ways)
    true_grid = Grid(np.where(plan, OCCUPIED, np.where(inside, FREE, -1)).astype(np.int8), (low[0], low[1]), cell)
    goals, good, stands = _goals(source, walkable, true_grid, truth_from_map, ways)
    return Score(
        float((values[is_floor] == FREE).mean()), float((values[is_floor & (about > PERSON)] == FREE).mean()),
        float(np.mean(wrong[is_wall])) if is_wall.any() else 0.0, goals, good,
        *_ways(stands, walkable, Walkable(true_grid, ways), truth_from_map, seed), 0.0, 0.0,
    )  # fmt: skip


def _goals(
    source: Source, walkable: Walkable, true_grid: Grid, truth_from_map: Array, ways: WayConfig
) -> tuple[int, int, list[Array]]:
    """How many signs a person could walk up to, before how many the goal is good, and where these stand in the map."""
    true_walkable, map_from_truth = Walkable(true_grid, ways), np.linalg.inv(truth_from_map)
    count, good, stands = 0, 0, []
    for sign in source.signs:
        if not sign.readable_frames:
            continue
        centre, normal = np.asarray(sign.centre, float), np.asarray(sign.normal, float)
        if not goal_before(centre, normal, true_walkable).is_before:
            continue
        here = transform_points(map_from_truth, centre[None])[0]
        if walkable.nearest(here, ways.goal_far) is None:
            continue  # nobody has seen the ground there
        count += 1
        goal = goal_before(here, map_from_truth[:3, :3] @ normal, walkable)
        stood = transform_points(truth_from_map, np.array([[*goal.position, 0.0]]))[0]
        cell = true_grid.cell(stood)
        clear = true_grid.has(cell) and true_walkable.clearance[cell] > ways.robot_radius - 0.07
        ahead = (stood - centre)[:2] @ normal[:2]
        if goal.is_before and clear and ahead > 0:
            good += 1
            stands.append(goal.position)
    return count, good, stands


def _ways(
    stands: list[Array], walkable: Walkable, true_walkable: Walkable, truth_from_map: Array, seed: int
) -> tuple[int, int, int, float]:
    """Ways between pairs of stands: how many, more than a tenth too long, through a wall; the median ratio."""
    random, ratios, through = np.random.default_rng(seed), [], 0
    plan = true_walkable.grid.values == OCCUPIED
    for _ in range(PAIRS):
        if len(stands) < 2:
            break
        first, last = random.choice(len(stands), 2, replace=False)
        try:
            way = walkable.way(stands[first], stands[last])
            ends = transform_points(truth_from_map, np.column_stack([way.points, np.zeros(len(way.points))]))
            best = true_walkable.way(ends[0], ends[-1])
        except NoWayError:
            continue
        if best.length > 1.0:
            ratios.append(way.length / best.length)
        dense = np.concatenate([np.linspace(a, b, 100) for a, b in pairwise(ends)])
        through += any(plan[true_walkable.grid.cell(place)] for place in dense)
    return len(ratios), int(np.sum(np.array(ratios) > 1.1)), through, float(np.median(ratios)) if ratios else 0.0


def main() -> None:
    """Print a table."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--seeds", default="401-406", help="malls, as 401-406")
    parser.add_argument("--worlds", help="drawn worlds instead, as 1003,1009")
    parser.add_argument("--frames", type=int, help="of the walk; all without")
    options = parser.parse_args()
    first, _, last = options.seeds.partition("-")
    seeds = range(int(first), int(last or first) + 1)
    if options.worlds:
        seeds = [int(each) for each in options.worlds.split(",")]
    print(
        "| Place | Floor free | Nobody there | Walls free | Strays | Goals | Ways | Over 1.1 | Through | Ratio | Scan |"
    )
    print("| --- | --- | --- | --- | --- | --- | --- | --- | --- | --- | --- |")
    for seed in seeds:
        source = WorldSource(draw_world(seed)) if options.worlds else MallSource(seed, options.frames)
        try:
            score = measure(source, seed)
        except UserError as error:
            print(f"| {seed} | {error} |", flush=True)
            continue
        print(
            f"| {seed} | {score.floor:.1%} | {score.empty_floor:.1%} | {score.walls:.2%} | {score.strays:.2f} m "
            f"| {score.good} of {score.goals} | {score.ways} | {score.long} | {score.through} | {score.ratio:.2f} "
            f"| {1000 * score.cost:.1f} ms |",
            flush=True,
        )


if __name__ == "__main__":
    main()
