"""A warning says what must not be done; a name that begins with those letters is a name."""

import pytest

from lpslam.language.offline import CANNOT_JUDGE, OfflineModel


@pytest.fixture(scope="module")
def model() -> OfflineModel:
    return OfflineModel()


@pytest.mark.parametrize("name", ["勿忘我花店", "小心肝烧烤", "高温瑜伽馆", "危险电玩城"])
def test_a_name_is_no_warning(model: OfflineModel, name: str) -> None:
    (warning,) = model.judge([name], "Is this a warning?")
    assert not warning.answer


def test_it_is_what_its_last_word_says(model: OfflineModel) -> None:
    assert model.judge(["小心肝烧烤"], "Is this a restaurant?")[0].answer
    assert model.judge(["高温瑜伽馆"], "Is this a gym?")[0].answer
    assert model.judge(["勿忘我花店"], "Is this a florist?")[0].answer


@pytest.mark.parametrize(
    "name", ["请勿进入餐厅", "小心台阶", "高温危险", "故障停用", "勿踩草坪", "禁止进入商店", "調整中"]
)
def test_a_warning_stays_one(model: OfflineModel, name: str) -> None:
    (warning,) = model.judge([name], "Is this a warning?")
    assert warning.answer


def test_what_is_not_understood_is_said(model: OfflineModel) -> None:
    (judged,) = model.judge(["Zara"], "Could a robot dock here?")
    assert (judged.answer, judged.confidence, judged.evidence) == (False, 0.0, CANNOT_JUDGE)
    assert "--llm" in CANNOT_JUDGE
