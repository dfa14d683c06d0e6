#!/usr/bin/python3
"""Trains the net that looks closely at one circle: is that a robot? From nothing, on painted rooms only: see README.md.

Usage: look.py SEARCH.onnx OUT.onnx [ROOMS] [EPOCHS]
"""
import multiprocessing
import sys

import cv2
import numpy as np
import torch
from torch import nn
from torch.nn import functional as F

import rooms
from fitting import fit, write

ANGLES, RADII = 64, 24  # what the net is shown: a circle's surroundings in polar coordinates, a row for each direction ...
SHOWN = 1.5  # ... out to so many radii
AGAIN = 25  # of the first rows, repeated after the last: a circle has no end, so the 8 directions of features are alike
MARGIN = 1.1  # so much more is copied: halving an odd length loses a pixel
LARGEST = 16  # the picture of a circle with a larger radius, in pixels, is halved


class LookNet(nn.Module):
    """What shown() gives to the logit of its being a robot. Turning the picture hardly changes the answer:
    the maximum and the mean of each feature over all directions count."""

    def __init__(self):
        super().__init__()
        layers = []
        for taken, given, wide, step in ((3, 16, 5, (2, 2)), (16, 32, 3, (2, 1)), (32, 40, 3, (2, 2)), (40, 40, 3, (1, 1))):
            layers += [nn.Conv2d(taken, given, wide, step, (0, wide // 2)), nn.BatchNorm2d(given), nn.ReLU()]
        self.layers = nn.Sequential(*layers)
        self.maximum, self.mean = nn.MaxPool2d((8, 1)), nn.AvgPool2d((8, 1))
        self.judge = nn.Sequential(nn.Conv2d(80, 24, (1, 6)), nn.ReLU(), nn.Conv2d(24, 1, 1))

    def forward(self, picture):
        features = self.layers(picture)
        return self.judge(torch.cat([self.maximum(features), self.mean(features)], 1))


def crop(picture, x, y, r):
    """The surroundings of a circle, ANGLES x RADII."""
    far = int(MARGIN * SHOWN * r) + 3
    left, top = int(round(x)) - far, int(round(y)) - far
    padded = cv2.copyMakeBorder(picture, *(max(0, v) for v in (-top, top + 2 * far + 1 - picture.shape[0], -left, left + 2 * far + 1 - picture.shape[1])),
                                cv2.BORDER_REPLICATE)
    part = padded[max(0, top):, max(0, left):][:2 * far + 1, :2 * far + 1]
    x, y = x - left, y - top
    while r > LARGEST:
        rows, columns = part.shape[0] // 2, part.shape[1] // 2
        part = cv2.resize(part[:2 * rows, :2 * columns], (columns, rows), interpolation=cv2.INTER_AREA)
        x, y, r = (x - 0.5) / 2, (y - 0.5) / 2, r / 2
    return cv2.warpPolar(part, (RADII, ANGLES), (x, y), SHOWN * r, cv2.INTER_LINEAR + cv2.WARP_FILL_OUTLIERS)


def shown(crops):
    """What the net gets of 8-bit crops: contrast and brightness are taken out."""
    values = crops.astype(np.float32).transpose(0, 3, 1, 2)
    values = (values - values.mean((1, 2, 3), keepdims=True)) / (values.std((1, 2, 3), keepdims=True) + 8)
    return np.concatenate([values, values[:, :, :AGAIN]], 2)


def finds(search, picture, r, least):
    """Circles that the search net sees at that radius."""
    scale = 5 / r
    small = cv2.resize(picture, None, fx=scale, fy=scale, interpolation=cv2.INTER_AREA if scale < 1 else cv2.INTER_LINEAR)
    if min(small.shape[:2]) < 16:
        return []
    search.setInput(cv2.dnn.blobFromImage(small, 1 / 255))
    maps = search.forward()[0]
    y, x = np.nonzero((maps[0] == cv2.dilate(maps[0], np.ones((3, 3)))) & (maps[0] > np.log(least / (1 - least))))
    place = lambda at, off, length, whole: ((at + 0.5 + off) * 4) * whole / length - 0.5
    return list(zip(place(x, maps[1, y, x], small.shape[1], picture.shape[1]), place(y, maps[2, y, x], small.shape[0], picture.shape[0]),
                    r * np.exp(np.clip(maps[3, y, x], -0.5, 0.5))))


def label(truth, x, y, r):
    """1: a robot, 0: none, None: nearly one."""
    if len(truth) == 0:
        return 0
    far = np.hypot(truth[:, 0] - x, truth[:, 1] - y) / truth[:, 2]
    size = abs(np.log(r / truth[far.argmin(), 2]))
    if far.min() < 0.2 and size < 0.15:
        return 1
    return 0 if far.min() > 0.55 or (far.min() < 0.4 and size > 0.24) else None


def looks(job):
    """Crops of one painted room and what they are: what the search net finds there at right and wrong sizes, what is
    round, the robots, and their coin cells."""
    search_path, seed = job
    cv2.setNumThreads(1)
    search = cv2.dnn.readNetFromONNX(search_path)
    picture, truth = rooms.room(seed, near=True)
    rng = np.random.default_rng([29, seed])
    r = truth[:, 2].mean() if len(truth) else 4 * 6.5 ** rng.random()
    circles = []
    for part in (1, 1, 0.5, 0.7, 1.4, 2):
        guess = np.clip(part * r * rng.uniform(0.9, 1.1), 3.5, 45)
        found = finds(search, picture, guess, 0.05)
        circles += [found[i] for i in rng.permutation(len(found))[:10]]
        round_ = cv2.HoughCircles(cv2.cvtColor(picture, cv2.COLOR_BGR2GRAY), cv2.HOUGH_GRADIENT, 1, guess, param1=rng.uniform(20, 100), param2=rng.uniform(6, 14),
                                  minRadius=int(0.8 * guess), maxRadius=int(1.25 * guess) + 1)
        circles += [tuple(c) for c in (round_.reshape(-1, 3)[:4] if round_ is not None else ())]
    robots = [truth[i] for i in rng.permutation(len(truth))[:8]]
    circles += [(*(t[:2] + rng.normal(0, 0.03 * t[2], 2)), t[2] * np.exp(rng.normal(0, 0.03))) for t in robots]
    circles += [(*(t[:2] + rng.normal(0, 0.05 * t[2], 2)), t[2] * rng.uniform(0.6, 0.78)) for t in robots[:3]]
    circles += [(*rooms.point(t[:2], rng.uniform(0, 7), rng.uniform(0.6, 1.3) * t[2]), t[2] * rng.uniform(0.8, 1.2)) for t in robots[:2]]
    out = []
    for x, y, radius in circles:
        if radius >= 3 and min(x, y, rooms.SIZE - 1 - x, rooms.SIZE - 1 - y) > 0.4 * radius and (what := label(truth, x, y, radius)) is not None:
            out.append((crop(picture, x, y, radius), what))
    return out


def train(crops, right, epochs, held_out):
    count = len(crops) - held_out

    def loss(net, chosen, chance):
        some = np.roll(crops[chosen], chance.integers(ANGLES), 1)
        some = some[:, ::-1] if chance.integers(2) else some
        some = shown(some * np.exp(chance.normal(0, 0.15, (len(some), 1, 1, 3))))
        return F.binary_cross_entropy_with_logits(net(torch.from_numpy(np.ascontiguousarray(some))).reshape(-1), torch.from_numpy(right[chosen]))

    net = fit(LookNet, count, 128, epochs, 6e-3, 1e-3, loss)
    with torch.no_grad():
        logits = torch.cat([net(torch.from_numpy(shown(part))).reshape(-1) for part in np.array_split(crops[count:], 20)]).numpy()
    robot = right[count:] > 0.5
    for least in (0.05, 0.2, 0.5, 0.8, 0.95):
        taken = logits > np.log(least / (1 - least))
        print(f"{least}: {(taken & robot).sum()} of {robot.sum()} robots, {(taken & ~robot).sum()} of {(~robot).sum()} others, in rooms not trained on")
    return net


if __name__ == "__main__":
    count = int(sys.argv[3]) if len(sys.argv) > 3 else 10000
    with multiprocessing.Pool() as pool:
        made = pool.map(looks, [(sys.argv[1], seed) for seed in range(count)], 16)
    held_out = sum(len(m) for m in made[-count // 20:])
    crops, right = np.stack([c[0] for m in made for c in m]), np.array([c[1] for m in made for c in m], np.float32)
    print(f"{len(crops)} looks, {int(right.sum())} of them at robots")
    write(train(crops, right, int(sys.argv[4]) if len(sys.argv) > 4 else 8, held_out), sys.argv[2], torch.zeros(1, 3, ANGLES + AGAIN, RADII), {0: "looks"})
