"""The table and the sheet of pictures of `run.py`."""
import os

import numpy as np
from PIL import Image, ImageDraw


def shown(rgb):
    """Khronos PBR Neutral and the sRGB curve: how `burnish compare` shows linear radiance. Bytes."""
    c = np.maximum(rgb[..., :3], 0.0)
    low = c.min(-1, keepdims=True)
    c = c - np.where(low < 0.08, low - 6.25 * low * low, 0.04)
    start, peak = 0.8 - 0.04, np.maximum(c.max(-1, keepdims=True), 1e-9)
    new = 1.0 - (1.0 - start) ** 2 / (peak + 1.0 - 2.0 * start)
    g = 1.0 - 1.0 / (0.15 * (peak - new) + 1.0)
    high = c * new / peak
    c = np.clip(np.where(peak < start, c, high + (new - high) * g), 0.0, 1.0)
    return (np.where(c <= 0.0031308, 12.92 * c, 1.055 * c ** (1 / 2.4) - 0.055) * 255 + 0.5).astype(np.uint8)


def sheet(rows, work, path, side=112):
    """Ours, three.js, their FLIP, Cycles and its FLIP, two presets beside each other."""
    columns = ["preview", "three", ("three", "preview"), "cycles", ("cycles", "preview")]
    columns = [c for c in columns if c in rows[0]["pictures"] or rows[0]["pairs"].get(c)]
    label, half = 14, (len(rows) + 1) // 2
    picture = Image.new("RGB", (2 * len(columns) * side + 8, half * (side + label)), (24, 24, 24))
    draw = ImageDraw.Draw(picture)
    for i, row in enumerate(rows):
        x, y = i // half * (len(columns) * side + 8), i % half * (side + label)
        flips = [f"{kind} {pair['flip_mean']:.3f}" for kind in ("three", "cycles") if (pair := row["pairs"][(kind, "preview")])]
        draw.text((x + 2, y + 1), f"{row['preset']}: {', '.join(flips)}", fill=(230, 230, 230))
        for k, column in enumerate(columns):
            is_map = isinstance(column, tuple)
            tile = Image.open(os.path.join(work, f"{row['name']}.{'-'.join(column)}.png")).convert("RGB") if is_map else Image.fromarray(shown(row["pictures"][column]))
            picture.paste(tile.resize((side, side), Image.LANCZOS), (x + k * side, y + label))
    picture.save(path, quality=85, optimize=True)


def write(rows, work, cover):
    """WORK/sheet.jpg and WORK/table.md; prints the table. `cover` is the share of the picture that is ball."""
    sheet(rows, work, os.path.join(work, "sheet.jpg"))

    def flip(row, pair): return f"{found['flip_mean']:.3f}" if (found := row["pairs"][pair]) else "-"

    def on_ball(row, pair): return f"{found['flip_mean'] / cover:.3f}" if (found := row["pairs"][pair]) else "-"

    def brightness(row, pair):
        found = row["pairs"][pair]
        return ", ".join(f"{100 * (x / y - 1):+.1f}" for x, y in zip(found["mean_rgb_a"], found["mean_rgb_b"])) if found else "-"

    table = "| preset | three.js | on the ball | R, G, B % | Cycles | on the ball | R, G, B % | our final view | final view, Cycles |\n"
    table += "| --- | --: | --: | --: | --: | --: | --: | --: | --: |\n"
    three, cycles = ("three", "preview"), ("cycles", "preview")
    for row in rows:
        cells = [row["preset"], flip(row, three), on_ball(row, three), brightness(row, three), flip(row, cycles), on_ball(row, cycles),
                 brightness(row, cycles), flip(row, ("final", "preview")), flip(row, ("cycles", "final"))]
        table += "| " + " | ".join(cells) + " |\n"
    with open(os.path.join(work, "table.md"), "w") as f: f.write(table)
    print(table, end="")
