"""A picture of a ColorChecker, 8 bits, for the tests that run other programs: chart or background at (x, y)."""

import struct
import zlib

WIDTH, HEIGHT, PITCH, LEFT, TOP = 420, 300, 56, 70, 66

# sRGB codes of the chart, roughly: the test compares two ways to the same picture, not colours.
PATCHES = """735244 c29682 627a9d 576c43 8580b1 67bdaa d67e2c 505ba6 c15a63 5e3c6c 9dbc40 e0a32e
             383d96 469449 af363c e7c71f bb5695 0885a1 f3f3f2 c8c8c8 a0a0a0 7a7a79 555555 343434""".split()


def write_png(path, colour_at):
    rows = b"".join(b"\0" + b"".join(bytes(colour_at(x, y)) for x in range(WIDTH)) for y in range(HEIGHT))

    def chunk(kind, data):
        return struct.pack(">I", len(data)) + kind + data + struct.pack(">I", zlib.crc32(kind + data))

    path.write_bytes(b"\x89PNG\r\n\x1a\n" + chunk(b"IHDR", struct.pack(">IIBBBBB", WIDTH, HEIGHT, 8, 2, 0, 0, 0)) +
                     chunk(b"IDAT", zlib.compress(rows)) + chunk(b"IEND", b""))


def background(x, y):
    return (90 + x // 12, 100 + y // 10, 80)


def chart(x, y):
    column, row = round((x - LEFT) / PITCH), round((y - TOP) / PITCH)
    dx, dy = abs(x - LEFT - column * PITCH), abs(y - TOP - row * PITCH)
    if not (-34 <= x - LEFT <= 5 * PITCH + 34 and -34 <= y - TOP <= 3 * PITCH + 34):
        return background(x, y)
    if 0 <= column < 6 and 0 <= row < 4 and dx <= 24 and dy <= 24:
        code = bytes.fromhex(PATCHES[6 * row + column])
        return (code[0] * 9 // 10, code[1] * 8 // 10, code[2] * 7 // 10)
    return (30, 28, 26)
