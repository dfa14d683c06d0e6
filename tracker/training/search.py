#!/usr/bin/python3
"""Trains the net that searches pictures for robots, from nothing, on painted rooms only: see README.md.

Usage: search.py OUT.onnx [ROOMS] [EPOCHS]
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

CELL = 4  # pixels of the net's picture to one of its answers


class SearchNet(nn.Module):
    """A picture, 0..1, blue first, to four maps: robot here (before the sigmoid), x and y off in cells, ln(radius / 5)."""

    def __init__(self):
        super().__init__()
        layers = []
        for taken, given, step, wide in ((3, 8, 2, 1), (8, 24, 2, 1), (24, 24, 1, 1), (24, 24, 1, 2), (24, 24, 1, 1)):
            layers += [nn.Conv2d(taken, given, 3, step, wide, dilation=wide), nn.BatchNorm2d(given), nn.ReLU()]
        self.layers = nn.Sequential(*layers, nn.Conv2d(24, 4, 1))
        self.layers[-1].bias.data[0] = -4

    def forward(self, picture):
        return self.layers(picture)


def target(truth):
    """Maps of what the net should answer, and of how much each cell counts."""
    size = rooms.SIZE // CELL
    heat, places, weight = np.zeros((size, size), np.float32), np.zeros((3, size, size), np.float32), np.ones((size, size), np.float32)
    nearest = np.full((size, size), 9.0)
    y, x = np.mgrid[0:size, 0:size].astype(float)
    for px, py, r in truth:
        cx, cy = (px + 0.5) / CELL - 0.5, (py + 0.5) / CELL - 0.5
        inside = min(px, py, rooms.SIZE - 1 - px, rooms.SIZE - 1 - py)
        d2 = (x - cx) ** 2 + (y - cy) ** 2
        if 3.6 <= r <= 6.7 and inside > 0.4 * r:
            heat = np.maximum(heat, np.exp(-d2 / (2 * 0.7**2)))
            closer = d2 < nearest
            nearest = np.where(closer, d2, nearest)
            for part, value in enumerate((cx - x, cy - y, np.full_like(x, np.log(r / 5)))):
                places[part] = np.where(closer, value, places[part])
        elif 3.1 < r < 7.1:  # a robot, but not wholly; or nearly of the size: no matter
            weight[d2 < (r / CELL) ** 2] = 0
    here = (nearest < 1.3**2).astype(np.float32)
    return np.concatenate([heat[None], weight[None], here[None], places]).astype(np.float32)


def loss_of(answer, wanted):
    heat, weight, here, places = wanted[:, 0], wanted[:, 1], wanted[:, 2], wanted[:, 3:]
    # Peaks count most; near ones are no mistake.
    sure = torch.sigmoid(answer[:, 0]).clamp(1e-4, 1 - 1e-4)
    peak = (heat > 0.35).float() * heat
    hot = -(peak * (1 - sure) ** 2 * torch.log(sure)).sum()
    cold = -((heat <= 0.35).float() * weight * (1 - heat) ** 4 * sure**2 * torch.log(1 - sure)).sum()
    off = (here[:, None] * (answer[:, 1:] - places).abs() * torch.tensor([1.0, 1.0, 4.0]).view(1, 3, 1, 1)).sum()
    return (hot + cold + 0.6 * off) / (here.sum() / 4 + 10)


def turned(pictures, truths, how):
    """Pictures and truths, mirrored and turned by quarters."""
    last = rooms.SIZE - 1
    if how & 1:
        pictures, truths = pictures[:, :, ::-1], [np.c_[last - t[:, 0], t[:, 1:]] for t in truths]
    if how & 2:
        pictures, truths = pictures[:, ::-1], [np.c_[t[:, 0], last - t[:, 1], t[:, 2]] for t in truths]
    if how & 4:
        pictures, truths = pictures.transpose(0, 2, 1, 3), [t[:, [1, 0, 2]] for t in truths]
    return pictures, truths


def train(pictures, truths, epochs, held_out=400):
    count = len(pictures) - held_out

    def loss(net, chosen, chance):
        shown, known = turned(pictures[chosen], [truths[i] for i in chosen], int(chance.integers(8)))
        wanted = torch.from_numpy(np.stack([target(t) for t in known]))
        return loss_of(net(torch.from_numpy(np.ascontiguousarray(shown.transpose(0, 3, 1, 2))).float() / 255), wanted)

    net = fit(SearchNet, count, 16, epochs, 4e-3, 1e-4, loss)
    calibrate(net, pictures[count:], truths[count:])
    print(accuracy(net, pictures[count:], truths[count:]))
    return net


def peaks_of(net, pictures):
    """Of each picture the places, in pixels, where the net rather sees a robot than beside, and its logits there."""
    with torch.no_grad():
        answer = torch.cat([net(torch.from_numpy(np.ascontiguousarray(part.transpose(0, 3, 1, 2))).float() / 255)
                            for part in np.array_split(pictures, 1 + len(pictures) // 50)]).numpy()
    highest = F.max_pool2d(torch.from_numpy(answer[:, :1]), 3, 1, 1)[:, 0].numpy()
    for maps, high in zip(answer, highest):
        y, x = np.nonzero((maps[0] == high) & (maps[0] > -3))
        yield np.stack([(x + maps[1, y, x] + 0.5) * CELL - 0.5, (y + maps[2, y, x] + 0.5) * CELL - 0.5], 1), maps[0, y, x]


def calibrate(net, pictures, truths):
    """Scales the net's scores, by logistic regression on rooms not trained on, so that they are probabilities."""
    odds, right = [], []
    for (at, logits), truth in zip(peaks_of(net, pictures), truths):
        for place, sure in zip(at, logits.tolist()):
            far = np.hypot(*(truth[:, :2] - place).T) / truth[:, 2] if len(truth) else np.array([9.0])
            size = truth[far.argmin(), 2] if len(truth) else 5
            inside = min(*place, *(rooms.SIZE - 1 - place)) > 0.4 * size
            if far.min() > 0.6 or (far.min() < 0.3 and 3.6 <= size <= 6.7 and inside):
                odds.append(sure), right.append(float(far.min() < 0.3))
    odds, right, scale = torch.tensor(odds), torch.tensor(right), torch.tensor([1.0, 0.0], requires_grad=True)
    fit = torch.optim.LBFGS([scale], max_iter=100)

    def loss():
        fit.zero_grad()
        wrong = F.binary_cross_entropy_with_logits(scale[0] * odds + scale[1], right)
        wrong.backward()
        return wrong

    fit.step(loss)
    slope, shift = scale.tolist()
    print(f"scores are made probabilities: {slope:.2f} of the logit {shift:+.2f}, {int(right.sum())} robots among {len(right)} places")
    last = net.layers[-1]
    last.weight.data[0] *= slope
    last.bias.data[0] = slope * last.bias.data[0] + shift


def accuracy(net, pictures, truths):
    """Of rooms not trained on: robots of the right size found within a quarter radius, and false finds, by threshold."""
    lines, seen = [], list(peaks_of(net, pictures))
    for least in (0.2, 0.3, 0.4, 0.5, 0.6):
        robots = found = false = 0
        for (places, logits), truth in zip(seen, truths):
            asked = [t for t in truth if 3.9 < t[2] < 6.4 and min(t[0], t[1], 159 - t[0], 159 - t[1]) > t[2]]
            robots += len(asked)
            at = places[logits > np.log(least / (1 - least))]
            found += sum(len(at) > 0 and np.hypot(*(at - t[:2]).T).min() < t[2] / 4 for t in asked)
            false += sum(len(truth) == 0 or (np.hypot(*(truth[:, :2] - a).T) / truth[:, 2]).min() > 0.6 for a in at)
        lines.append(f"{least}: {found} of {robots} found, {false} false")
    return "\n".join(lines)


if __name__ == "__main__":
    cv2.setNumThreads(1)
    with multiprocessing.Pool() as pool:
        made = pool.map(rooms.room, range(int(sys.argv[2]) if len(sys.argv) > 2 else 8000), 16)
    write(train(np.stack([m[0] for m in made]), [m[1] for m in made], int(sys.argv[3]) if len(sys.argv) > 3 else 15), sys.argv[1],
          torch.zeros(1, 3, rooms.SIZE, rooms.SIZE), {2: "height", 3: "width"})
