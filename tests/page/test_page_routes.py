"""What a server gives of a page: the page at once, and the rest of the map when it is asked for."""

import json
from collections.abc import Iterator

import numpy as np
import pytest
from starlette.applications import Starlette
from starlette.testclient import TestClient

from lpslam.config import PageConfig
from lpslam.mapfile.language_map import LanguageMap
from lpslam.page.routes import Pages, page_routes
from lpslam.text.sightings import Sighting
from small_maps import small_map, with_floor


class Maps:
    """One map, and how often it was asked for."""

    def __init__(self) -> None:
        self.world = with_floor(small_map(signs=("KFC", "ATM")))
        picture = Sighting(0, (0.0, -1.0, 0.0), 9.0, b"\xff\xd8\xff picture")
        self.world.text.sightings.keep(0, picture, lambda key: True)
        self.version = "1"

    def find(self, name: str | None) -> tuple[str, str, LanguageMap]:
        if name not in (None, "mall"):
            raise LookupError("no map of that name is served")
        return "mall", self.version, self.world


@pytest.fixture
def maps() -> Maps:
    return Maps()


@pytest.fixture
def client(maps: Maps) -> Iterator[TestClient]:
    with TestClient(Starlette(routes=list(page_routes(Pages(maps.find, PageConfig(points=300)))))) as opened:
        yield opened


def test_ground_points_and_pictures_come_after_the_page(client: TestClient) -> None:
    page = client.get("/")
    assert page.status_code == 200
    assert "data:image/jpeg" not in page.text
    assert "frame-ancestors 'none'" in page.headers["content-security-policy"]
    ground = client.get("/page/mall/ground").json()
    assert ground["picture"].startswith("data:image/png;base64,")
    assert ground["height"] == pytest.approx(-1.2, abs=0.05)
    points = client.get("/page/mall/points")
    assert points.headers["content-type"] == "application/octet-stream"
    assert np.frombuffer(points.content[:4], "<f4") == 300
    assert len(points.content) == 32 + 300 * 8
    assert list(client.get("/page/mall/pictures").json()) == ["0"]
    assert [sign["name"] for sign in client.get("/page/mall/signs").json()["signs"]] == ["KFC", "ATM"]


def test_where_no_floor_was_seen_there_is_no_ground(client: TestClient, maps: Maps) -> None:
    maps.world.scans = None
    assert client.get("/page/mall/ground").json() is None
    # The map's own points are shown instead.
    assert np.frombuffer(client.get("/page/mall/points").content[:4], "<f4") == len(maps.world.cloud())


def test_what_was_made_is_kept_until_the_map_is_replaced(client: TestClient, maps: Maps) -> None:
    first = client.get("/page/mall/points").content
    maps.world = with_floor(small_map(signs=("KFC",)), height=2.0)
    assert client.get("/page/mall/points").content == first
    maps.version = "2"
    assert client.get("/page/mall/points").content != first


@pytest.mark.parametrize("part", ["", "/ground", "/points", "/pictures", "/signs"])
def test_a_map_that_is_not_served_is_not_found(client: TestClient, part: str) -> None:
    assert client.get(f"/page/other{part}").status_code == 404


def test_the_way_tells_where_the_camera_was_and_how_it_was_turned(client: TestClient) -> None:
    text = client.get("/").text
    data = json.loads(text.partition('id="map-data">')[2].partition("</script>")[0])
    ((x, y, z, *turn, seconds),) = data["trajectory"]
    assert (x, y, z, seconds) == (0, 0, 0, 0)
    # From the optical frame to one that looks along x: half of all turns at once.
    np.testing.assert_allclose(turn, [-0.5, 0.5, -0.5, 0.5], atol=1e-4)
    assert data["lens"] == [320, 240, 300, 300, 159.5, 119.5]
