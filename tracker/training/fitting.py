"""What the training of both nets has in common: steps of gradient descent, and the file of weights."""
import time

import numpy as np
import torch
from torch import nn
from torch.nn.utils.fusion import fuse_conv_bn_eval

SEED = 1


def fit(make_net, count, batch, epochs, rate, decay, loss_of):
    """Trains a net from nothing on `count` examples; loss_of(net, indices of a batch, random generator)."""
    torch.manual_seed(SEED)
    torch.set_num_threads(1)
    chance, net = np.random.default_rng(SEED), make_net()
    steps = epochs * (count // batch)
    optimiser = torch.optim.AdamW(net.parameters(), rate, weight_decay=decay)
    schedule = torch.optim.lr_scheduler.OneCycleLR(optimiser, rate, steps, pct_start=0.1)
    began, sum_ = time.time(), 0.0
    for step in range(steps):
        if step % (count // batch) == 0:
            order = chance.permutation(count)
        loss = loss_of(net, order[step % (count // batch) * batch:][:batch], chance)
        optimiser.zero_grad()
        loss.backward()
        optimiser.step()
        schedule.step()
        sum_ += loss.item()
        if (step + 1) % 200 == 0:
            print(f"step {step + 1} of {steps}, loss {sum_ / 200:.4f}, {time.time() - began:.0f} s", flush=True)
            sum_ = 0.0
    return net.eval()


def write(net, path, shown, free):
    """ONNX for input like `shown`, whose dimensions `free` may have other lengths; weights rounded to half floats, norms put into them."""
    plain = [fuse_conv_bn_eval(one, after) if isinstance(after, nn.BatchNorm2d) else one
             for one, after in zip(net.layers, [*net.layers[1:], None]) if not isinstance(one, nn.BatchNorm2d)]
    net.layers = nn.Sequential(*plain).eval()
    for weight in net.parameters():
        weight.data = weight.data.half().float()
    torch.onnx.export(net, shown, path, input_names=["picture"], output_names=["robots"], dynamic_axes={"picture": free, "robots": free}, opset_version=11)
