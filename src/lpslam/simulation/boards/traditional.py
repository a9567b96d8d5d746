"""The words of boards in traditional characters."""

# Only what the boards' words need; what is written in two ways (面, 发) goes by the word that it stands in.
_PAIRS = (
    "楼樓 馆館 饺餃 锅鍋 烧燒 厅廳 药藥 镜鏡 书書 装裝 宝寶 诊診 宾賓 电電 鸿鴻 兴興 顺順 万萬 丰豐 达達 "
    "记記 斋齋 轩軒 阁閣 发發 来來 园園 华華 广廣 云雲 边邊 风風 鹭鷺 东東 篱籬 桥橋 间間 长長 张張 刘劉 "
    "陈陳 杨楊 赵趙 黄黃 吴吳 孙孫 马馬 罗羅 诚誠 经經 营營 业業 质質 证證 欢歡 临臨 传傳 统統 艺藝 场場 "
    "卖賣 于於 设設 胜勝 话話 订訂 热熱 线線 号號 时時 鹅鵝 鸡雞 鱼魚 汤湯 酱醬 凉涼 夹夾 馍饃 鲜鮮 鸭鴨 "
    "蚝蠔 现現 萝蘿 饭飯 炉爐 饼餅 价價 门門 锁鎖 参參 验驗 专專 阳陽 隐隱 递遞 篮籃 衬襯 裤褲 钻鑽 龙龍 "
    "红紅 烫燙 护護 绒絨 单單 双雙 钟鐘 车車 洁潔 适適 维維 调調 机機 视視 体體 儿兒 内內 针針 图圖 说說 "
    "旧舊 点點 检檢 帘簾 柠檸 条條 粤粵 冲沖 "
)
_TABLE = str.maketrans({pair[0]: pair[1] for pair in _PAIRS.split()})
_NOODLES = ("拉面", "牛肉面", "炸酱面", "云吞面", "面馆", "面包")
_HAIR = ("理发", "染发", "烫发")


def traditional(text: str) -> str:
    """The same words as they are written where characters were not simplified."""
    for word in _NOODLES:
        text = text.replace(word, word.replace("面", "麵"))
    for word in _HAIR:
        text = text.replace(word, word.replace("发", "髮"))
    return text.translate(_TABLE)
