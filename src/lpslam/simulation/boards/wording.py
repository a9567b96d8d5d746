"""What a shop's board says, line by line and by role, composed from word lists with a seed."""

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Literal

import numpy as np

from lpslam.simulation.boards.traditional import traditional

Role = Literal["primary", "secondary", "contact", "list"]
Script = Literal["simplified", "traditional", "english", "mixed"]
ROLES: tuple[Role, ...] = ("primary", "secondary", "contact", "list")
SCRIPTS: tuple[Script, ...] = ("simplified", "traditional", "english", "mixed")


@dataclass(frozen=True, slots=True)
class Saying:
    """One line of a board and its role: the name, a slogan or trade, how to reach it, or what is sold."""

    text: str
    role: Role


@dataclass(frozen=True, slots=True)
class Trade:
    """A kind of shop: how its name ends in Chinese, what it is in English, what it says of itself, what it sells."""

    chinese: str
    english: str
    motto: str
    items: tuple[str, ...]


def _words(listed: str) -> tuple[str, ...]:
    return tuple(listed.split())


def _trades(table: str) -> tuple[Trade, ...]:
    rows = [row.split("|") for row in table.strip().splitlines()]
    return tuple(Trade(chinese, english, motto, tuple(items.split())) for chinese, english, motto, items in rows)


TRADES = _trades("""
酒楼|Restaurant|正宗粤菜|烧鹅 白切鸡 清蒸鱼 例汤
面馆|Noodles|手工拉面|牛肉面 炸酱面 凉皮 肉夹馍
饺子馆|Dumplings|现包现煮|三鲜饺子 白菜饺子 酸辣汤 小菜
火锅|Hot Pot|麻辣鲜香|毛肚 鸭血 羊肉 豆腐
烧烤|Barbecue|炭火现烤|羊肉串 鸡翅 烤鱼 生蚝
茶餐厅|Tea Restaurant|港式风味|菠萝包 奶茶 云吞面 煲仔饭
烘焙|Bakery|每日新鲜出炉|面包 蛋糕 酥饼 咖啡
奶茶|Bubble Tea|第二杯半价|珍珠奶茶 柠檬茶 芒果冰 椰奶
五金|Hardware|建材批零|水管 电线 门锁 油漆
药房|Pharmacy|中药西药|参茸 凉茶 配方 煎药
眼镜|Optician|专业验光配镜|太阳镜 老花镜 隐形 镜架
书店|Books|新书旧书|教材 字典 小说 地图
花店|Florist|鲜花速递|玫瑰 百合 盆景 花篮
服装|Fashion|新款上市|衬衫 西裤 外套 童装
珠宝|Jewellery|黄金翡翠|金条 玉器 钻石 回收
茶行|Tea Merchant|高山好茶|龙井 普洱 红茶 茶具
理发|Barber|剪烫染护|洗剪吹 染发 烫发 修面
照相馆|Photo Studio|立等可取|证件照 全家福 冲印 相框
洗衣|Laundry|衣物如新|西装 羽绒 皮衣 窗帘
诊所|Clinic|内科儿科|针灸 推拿 牙科 体检
宾馆|Hotel|整洁舒适|单人房 双人房 钟点房 停车
电器|Appliances|维修安装|空调 冰箱 手机 电视
""")
FIRST = "福兴金鸿永德顺祥瑞万宝泰和盛恒聚广新安大"
SECOND = "源昌隆丰达利记斋坊轩堂阁发来城园华生"
PLACES = _words("青山 云水 月下 南巷 北街 江边 竹林 梧桐 春风 秋水 白鹭 半山 东篱 西湖 石桥 海角 松间 小院 星河 长安")
SURNAMES = _words("王 李 张 刘 陈 杨 赵 黄 周 吴 徐 孙 马 朱 胡 林 郭 何 高 罗")
CHINESE_MOTTOES = _words("诚信经营 百年老店 品质保证 欢迎光临 传统工艺 全场八折 外卖送餐 批发零售 老字号 始于一九八七")
ROADS = _words("中山 人民 解放 和平 建设 文化 长江 东风 新华 胜利")
ADJECTIVES = _words(
    "Copper Velvet Amber Quiet Golden Crooked Silver Little Hidden Rusty Scarlet Northern Honest Lucky Paper Wild "
    "Painted Humble Winter Merry Ivory Salty Mossy Broken Gentle Marble Smoky Bright Hollow Emerald"
)
NOUNS = _words(
    "Lantern Finch Harbour Barrel Anchor Thistle Kettle Fox Orchard Compass Badger Willow Mill Raven Bridge Acorn "
    "Ladder Heron Cellar Clover Otter Garden Feather Tiger Window Pebble Walnut Sparrow Meadow Hammer"
)
PEOPLE = _words("Molly Hector Nadia Oscar Priya Ruben Sylvia Tomas Ursula Victor Wendy Yusuf Agnes Bruno Celia Dario")
ENGLISH_MOTTOES = (
    "SINCE 1987", "OPEN DAILY", "FRESH EVERY DAY", "FAMILY OWNED", "QUALITY FIRST", "Hand made here", "Come on in",
    "ALL DAY BREAKFAST", "50% OFF TODAY", "Best in town", "TAKE AWAY",
)  # fmt: skip
ENGLISH_ITEMS = _words("Coffee Tea Cakes Soup Pies Bread Keys Paint Flowers Gifts Shoes Maps Cards Repairs Juice Salad")
STREETS = ("Harbour Road", "Mill Lane", "Station Street", "King Street", "Canal Walk", "Temple Row")
OTHER_LINES = 4  # at most, beside the name


def compose(rng: np.random.Generator, script: Script) -> tuple[Saying, ...]:
    """Say what one board shows: its name first, then up to four other lines."""
    trade = TRADES[int(rng.integers(len(TRADES)))]
    is_english = script == "english" or (script == "mixed" and rng.random() < 0.4)
    name = _english_name(rng, trade) if is_english else _chinese_name(rng, trade)
    others: list[Saying] = []
    if script == "mixed":
        # The other language says the trade, or the name of the place.
        others.append(Saying(trade.chinese if is_english else trade.english.upper(), "secondary"))
    count = int(rng.choice(OTHER_LINES + 1, p=(0.2, 0.3, 0.25, 0.15, 0.1)))
    kinds = rng.permutation(np.array(["secondary", "secondary", "contact", "contact", "list"]))[:count]
    draw = _english_line if is_english else _chinese_line
    for kind in kinds.tolist():
        others += draw(rng, trade, kind)
    told = {name}
    unique = [each for each in others if not (each.text in told or told.add(each.text))]  # type: ignore[func-returns-value]
    lines = (Saying(name, "primary"), *unique[:OTHER_LINES])
    if script == "traditional":
        lines = tuple(Saying(traditional(line.text), line.role) for line in lines)
    return lines


def characters() -> str:
    """Every character that a board may show, sorted: what the fonts must contain."""
    words: list[str] = [*PLACES, *SURNAMES, *CHINESE_MOTTOES, *ROADS, FIRST, SECOND, _CONTACT_WORDS, "老阿小"]
    words += [word for trade in TRADES for word in (trade.chinese, trade.motto, *trade.items)]
    plain = "".join(words)
    return "".join(sorted(set(plain + traditional(plain))))


def _pick(rng: np.random.Generator, words: Sequence[str]) -> str:
    return words[int(rng.integers(len(words)))]


def _chinese_name(rng: np.random.Generator, trade: Trade) -> str:
    way = rng.random()
    if way < 0.45:
        start = _pick(rng, FIRST) + _pick(rng, SECOND)
    elif way < 0.75:
        start = _pick(rng, PLACES)
    else:
        surname = _pick(rng, SURNAMES)
        start = f"{surname}记" if rng.random() < 0.5 else f"{_pick(rng, '老阿小')}{surname}"
    return start + trade.chinese


def _english_name(rng: np.random.Generator, trade: Trade) -> str:
    way = rng.random()
    if way < 0.4:
        name = f"{_pick(rng, ADJECTIVES)} {_pick(rng, NOUNS)}"
    elif way < 0.6:
        first, second = rng.choice(len(NOUNS), 2, replace=False)
        name = f"{NOUNS[int(first)]} & {NOUNS[int(second)]}"
    elif way < 0.8:
        name = f"{_pick(rng, PEOPLE)}'s {trade.english}"
    else:
        name = f"{_pick(rng, NOUNS)} {trade.english}"
    return name.upper() if rng.random() < 0.4 else name


_CONTACT_WORDS = "电话订餐热线路号营业时间元"


def _chinese_line(rng: np.random.Generator, trade: Trade, kind: str) -> list[Saying]:
    if kind == "secondary":
        return [Saying(trade.motto if rng.random() < 0.5 else _pick(rng, CHINESE_MOTTOES), "secondary")]
    if kind == "contact":
        number = f"{rng.integers(2000, 8999)}{rng.integers(1000, 9999)}"
        choices = (
            f"电话 {number}",
            f"订餐热线 {number[:4]} {number[4:]}",
            f"{_pick(rng, ROADS)}路{rng.integers(1, 398)}号",
            f"营业时间 {rng.integers(7, 11)}:00-{rng.integers(20, 24)}:30",
        )
        return [Saying(_pick(rng, choices), "contact")]
    count = int(rng.integers(2, 5))
    with_price = rng.random() < 0.5
    picked = rng.permutation(len(trade.items))[:count].tolist()
    return [Saying(trade.items[i] + (f" {rng.integers(6, 88)}元" if with_price else ""), "list") for i in picked]


def _english_line(rng: np.random.Generator, trade: Trade, kind: str) -> list[Saying]:
    if kind == "secondary":
        return [Saying(trade.english.upper() if rng.random() < 0.4 else _pick(rng, ENGLISH_MOTTOES), "secondary")]
    if kind == "contact":
        choices = (
            f"TEL 020 7946 {rng.integers(1000, 9999):04d}",
            f"{rng.integers(1, 398)} {_pick(rng, STREETS)}",
            f"MON-SAT {rng.integers(7, 11)}:00-{rng.integers(17, 22)}:30",
        )
        return [Saying(_pick(rng, choices), "contact")]
    count = int(rng.integers(2, 5))
    with_price = rng.random() < 0.5
    picked = rng.permutation(len(ENGLISH_ITEMS))[:count].tolist()
    prices = [f" {rng.integers(1, 12)}.{rng.choice([50, 80, 90])}" if with_price else "" for _ in picked]
    return [Saying(ENGLISH_ITEMS[i] + price, "list") for i, price in zip(picked, prices, strict=True)]
