"""What the signs of a mock mall say: real brands, invented shops, facilities, warnings and slogans."""

from dataclasses import dataclass
from typing import Literal

Kind = Literal["shop", "restaurant", "facility", "warning", "slogan"]
Language = Literal["mixed", "chinese", "english"]


@dataclass(frozen=True, slots=True)
class Wording:
    """One thing a sign can say; at least one of the two languages is given."""

    english: str
    chinese: str
    kind: Kind

    def lines(self, language: Language) -> tuple[str, ...]:
        """The lines available in a language, English first; empty when it has none."""
        wanted = {"mixed": (self.english, self.chinese), "chinese": (self.chinese,), "english": (self.english,)}
        return tuple(line for line in wanted[language] if line)


_SHOPS = """
HUAWEI|华为
GUCCI|古驰
ALIENWARE|外星人电脑
adidas|阿迪达斯
NIKE|耐克
UNIQLO|优衣库
ZARA|
LEGO|乐高
Lenovo|联想
MUJI|无印良品
Watsons|屈臣氏
SEPHORA|丝芙兰
Swarovski|施华洛世奇
CASIO|卡西欧
Canon|佳能
SONY|索尼
SAMSUNG|三星
Xiaomi|小米之家
LANCOME|兰蔻
Levi's|
PANDORA|潘多拉
Timberland|
Columbia|哥伦比亚
SKECHERS|斯凯奇
Miniso|名创优品
Nintendo|任天堂
Decathlon|迪卡侬
Crocs|
ROLEX|劳力士
PRADA|普拉达
CHANEL|香奈儿
Hermes|爱马仕
Li-Ning|李宁
ANTA|安踏
|老凤祥
|周大福
|周生生珠宝
|同仁堂
|新华书店
|回力
Willow & Pine|
Moonlight Books|月光书店
Velvet Lane|
Cobalt Optics|蓝光眼镜
Silver Needle|银针裁缝
Green Thumb|绿手指花店
Little Acorn|小橡果童装
Paper Crane|纸鹤文具
Harbor Cycle|海港单车
Blue Kettle|
Tiny Planet Toys|小星球玩具
Fern & Stone|
North Star Outdoor|北极星户外
Copper Fox|
Pixel Garage|像素车库
Luna Jewelry|月亮珠宝
Mirror Mirror|
Atlas Luggage|行者箱包
Orchid Salon|兰花美发
Maple Pharmacy|枫叶药房
Urban Thread|
Vinyl Corner|
Sunday Home|周日家居
Cloud Nine Beds|云端家纺
|春风服饰
|锦绣丝绸
|四季花店
|大众影院
|佳佳超市
|光明眼镜
|童年玩具
|时光钟表
|快乐宠物
|远航旅行社
|东方美术
|晨光文具
""".strip().splitlines()

_RESTAURANTS = """
KFC|肯德基
Pizza Hut|必胜客欢乐餐厅
McDonald's|麦当劳
Starbucks|星巴克
Burger King|汉堡王
SUBWAY|赛百味
HEYTEA|喜茶
Luckin Coffee|瑞幸咖啡
Haidilao|海底捞火锅
Yonghe King|永和大王
Dicos|德克士
Domino's|达美乐
Costa Coffee|咖世家
Ajisen Ramen|味千拉面
YOSHINOYA|吉野家
Mixue|蜜雪冰城
CoCo|都可
|全聚德烤鸭
|狗不理包子
|真功夫
|西贝莜面村
|沙县小吃
|兰州拉面
Golden Wok|金锅小炒
Dragon Noodle|龙须面馆
Sakura Sushi|樱花寿司
Bamboo Garden|竹园餐厅
Casa Roma|
The Daily Bread|
Mango Tree|芒果树甜品
Panda Dumpling|熊猫饺子馆
Ocean Grill|海洋烧烤
Brick Oven Pizza|
Olive & Thyme|
Sweet Tooth|甜心蛋糕
Steam House|蒸汽茶楼
Red Lantern|红灯笼酒家
Cafe Mocha|
Juice Lab|
Taco Verde|
|江南小厨
|老街牛肉面
|兰亭茶社
|外婆家
|川味人家
|湘江渔村
|豆浆油条
|南京大牌档
""".strip().splitlines()

_FACILITIES = """
WASHROOM|洗手间
RESTROOM|卫生间
EXIT|出口
FIRE EXIT|安全出口
ATM|自动取款机
ELEVATOR|电梯
ESCALATOR|自动扶梯
INFORMATION|服务台
PARKING|停车场
FIRST AID|医务室
STAIRS|楼梯
BABY CARE|母婴室
LOCKERS|寄存处
TICKETS|售票处
DRINKING WATER|饮水处
MEETING ROOM|会议室
CASHIER|收银台
LOST & FOUND|失物招领
TAXI|出租车
LIBRARY|图书馆
""".strip().splitlines()

_WARNINGS = """
NO SMOKING|禁止吸烟
Don't Touch|请勿触摸
Do Not Beat|请勿拍打
DANGER|危险
HIGH TEMPERATURE|高温危险
WET FLOOR|小心地滑
MIND THE STEP|小心台阶
NO ENTRY|禁止入内
HIGH VOLTAGE|高压危险
STAFF ONLY|闲人免进
NO PHOTOS|禁止拍照
NO PETS|禁止宠物入内
KEEP CLEAR|请勿堆放
Caution|当心碰头
DO NOT LEAN|请勿倚靠
NO RUNNING|请勿奔跑
""".strip().splitlines()

_SLOGANS = """
Save Water|节约用水
Enjoy Every Day|享受每一天
BIG SALE|全场五折
New Arrivals|新品上市
Happy Shopping|购物愉快
Welcome|欢迎光临
Go Green|绿色生活
Customers First|顾客至上
Free Delivery|免费送货
Buy One Get One|买一送一
Thank You|谢谢惠顾
Smile Today|微笑每一天
Think Different Eat Well|
|文明购物
|光盘行动
|安全第一
|会员日
""".strip().splitlines()


def _parse(lines: list[str], kind: Kind) -> tuple[Wording, ...]:
    pairs = (line.split("|") for line in lines)
    return tuple(Wording(english, chinese, kind) for english, chinese in pairs)


SHOPS = _parse(_SHOPS, "shop")
RESTAURANTS = _parse(_RESTAURANTS, "restaurant")
FACILITIES = _parse(_FACILITIES, "facility")
WARNINGS = _parse(_WARNINGS, "warning")
SLOGANS = _parse(_SLOGANS, "slogan")
EVERYTHING = SHOPS + RESTAURANTS + FACILITIES + WARNINGS + SLOGANS

SIMILAR = (
    *_parse(["GAP|", "GAO|", "|晨光花店", "|星光花店"], "shop"),
    *_parse(["|金龙小吃", "|金龙小炒", "Blue Harbor|", "Blue Arbor|"], "restaurant"),
    *_parse(["EXIT|", "EXIT 2|", "MEETING ROOM 1|", "MEETING ROOM 2|"], "facility"),
)
"""Different places whose names differ by a letter or two."""


def characters() -> str:
    """Every character that a sign may show, sorted: what the sign fonts must contain."""
    return "".join(sorted({letter for wording in EVERYTHING + SIMILAR for letter in wording.english + wording.chinese}))
