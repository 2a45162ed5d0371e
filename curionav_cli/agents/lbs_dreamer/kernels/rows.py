"""Operations of a step of the RSSM on rows of numbers, several in one pass, compiled by numba (the extra `fast`).

Each is the same computation as in torch but for rounding: e^x has an error of 1e-7, sums are added in another order.

Letters: B rows, D GRU units, U hidden units, S latents, C classes. Arrays are float32 and, but for noise, contiguous.
"""

from __future__ import annotations

import numpy as np
from numba import njit

compiled = njit(cache=True, nogil=True, error_model="numpy", fastmath={"reassoc", "contract", "nsz"})
inlined = njit(cache=True, inline="always")

ZERO, HALF, ONE, TWO = (np.float32(x) for x in (0, 0.5, 1, 2))
LEAST, MOST = np.float32(-87), np.float32(88)  # between which e^x is a normal number
LOG2_E, LN2_HIGH, LN2_LOW = np.float32(1.4426950408889634), np.float32(0.693359375), np.float32(-2.12194440e-4)
P6, P5, P4, P3, P2 = (np.float32(x) for x in (1 / 720, 1 / 120, 1 / 24, 1 / 6, 1 / 2))
BIAS, MANTISSA = np.int32(127), np.int32(23)  # of a float32


@inlined
def exp(x):
    """e^x: 2^n e^r with the nearest whole n, and e^r by its series, as |r| < 0.35."""
    x = min(max(x, LEAST), MOST)
    n = np.floor(x * LOG2_E + HALF)
    r = x - n * LN2_HIGH - n * LN2_LOW
    series = ((((P6 * r + P5) * r + P4) * r + P3) * r + P2) * r * r + r + ONE
    return series * np.int32((np.int32(n) + BIAS) << MANTISSA).view(np.float32)


@inlined
def sigmoid(x):
    return ONE / (ONE + exp(-x))


@inlined
def tanh(x):
    return ONE - TWO / (exp(TWO * x) + ONE)


@inlined
def elu(x):
    return exp(x) - ONE if x <= ZERO else x  # so that what is not a number stays that


@compiled
def elu_(x):
    """x (n,) = elu(x), in place."""
    for i in range(len(x)):
        x[i] = elu(x[i])


@compiled
def add_elu(x, added):
    """x (B, U) = elu(x + added), in place; added (B, U)."""
    for row in range(len(x)):
        for i in range(x.shape[1]):
            total = x[row, i] + added[row, i]
            x[row, i] = elu(total)


@compiled
def add_bias_elu(x, bias):
    """x (B, U) = elu(x + bias), in place; bias (U,)."""
    for row in range(len(x)):
        for i in range(x.shape[1]):
            total = x[row, i] + bias[i]
            x[row, i] = elu(total)


@compiled
def add_bias(x, bias):
    """x (B, U) = x + bias, in place; bias (U,)."""
    for row in range(len(x)):
        for i in range(x.shape[1]):
            x[row, i] += bias[i]


@compiled
def elu_slope(slope, result):
    """slope (B, U) = the gradient of elu's input, in place, from that of its result and the result."""
    for row in range(len(slope)):
        for i in range(slope.shape[1]):
            slope[row, i] *= result[row, i] + ONE if result[row, i] <= ZERO else ONE


@compiled
def elu_beside(before, deter, joined):
    """joined (B, U + D) = [elu(before), deter]."""
    units = before.shape[1]
    for row in range(len(before)):
        for i in range(units):
            joined[row, i] = elu(before[row, i])
        joined[row, units:] = deter[row]


@compiled
def add_columns(ones, table, bias, left, right):
    """left (B, V) = bias + sums of the rows `ones` (B, S) of table[:, :V], right (B, U) = those of table[:, V:]."""
    units, width = left.shape[1], np.uint64(table.shape[1])  # unsigned, or the compiler adds one number at a time
    flat, total = table.reshape(-1), np.empty(table.shape[1], np.float32)
    for row in range(len(ones)):
        total[:units] = bias
        total[units:] = ZERO
        for latent in range(ones.shape[1]):
            first = np.uint64(ones[row, latent]) * width
            for i in range(width):
                total[i] += flat[first + i]
        left[row] = total[:units]
        right[row] = total[units:]


@compiled
def choose(logits, noise, action):
    """Draw action (B,) from softmax(logits), (B, A), by noise (B,), as behaviour.sample_action."""
    for row in range(len(logits)):
        most, total, reached, chosen = logits[row].max(), ZERO, ZERO, 0
        for a in range(logits.shape[1]):
            total += exp(logits[row, a] - most)
        for a in range(logits.shape[1]):
            reached += exp(logits[row, a] - most) / total
            chosen += reached <= noise[row]
        action[row] = min(chosen, logits.shape[1] - 1)


@compiled
def gru(gates, gain, shift, epsilon, before, deter, normed, mean, scale):
    """LayerNorm and gates: from g (B, 3 D) and h_{t-1} (B, D) to h_t, [r, c, u], and g's mean and inverse deviation."""
    size, count = before.shape[1], np.float32(gates.shape[1])
    for row in range(len(gates)):
        g, n, old, new = gates[row], normed[row], before[row], deter[row]
        total = ZERO
        for i in range(len(g)):
            total += g[i]
        middle, square = total / count, ZERO
        for i in range(len(g)):
            square += (g[i] - middle) * (g[i] - middle)
        inverse = ONE / np.sqrt(square / count + epsilon)
        for i in range(len(g)):
            n[i] = (g[i] - middle) * inverse * gain[i] + shift[i]
        for i in range(size):
            proposal = tanh(sigmoid(n[i]) * n[size + i])
            new[i] = old[i] + sigmoid(n[2 * size + i] - ONE) * (proposal - old[i])
        mean[row, 0], scale[row, 0] = middle, inverse


@compiled
def gru_backward(gradient, before, gates, normed, mean, scale, gain, to_normed, to_gates, direct):
    """The gradient of `gru`: from h' (B, D) to [r', c', u'] and g' (B, 3 D), and h' (1 - V)."""
    size, count = before.shape[1], np.float32(gates.shape[1])
    for row in range(len(gates)):
        n, g, to_n, to_g = normed[row], gates[row], to_normed[row], to_gates[row]
        for i in range(size):
            to_n[i] = sigmoid(n[i])
        for i in range(size):
            to_n[size + i] = tanh(to_n[i] * n[size + i])
        for i in range(size):
            to_n[2 * size + i] = sigmoid(n[2 * size + i] - ONE)
        for i in range(size):
            h, candidate, reset = gradient[row, i], n[size + i], to_n[i]
            proposal, update = to_n[size + i], to_n[2 * size + i]
            inner = h * update * (ONE - proposal * proposal)
            to_n[i] = inner * candidate * reset * (ONE - reset)
            to_n[size + i] = inner * reset
            to_n[2 * size + i] = h * (proposal - before[row, i]) * update * (ONE - update)
            direct[row, i] = h - h * update
        middle, inverse, total, product = mean[row, 0], scale[row, 0], ZERO, ZERO
        for i in range(len(g)):
            total += to_n[i] * gain[i]
            product += to_n[i] * gain[i] * (g[i] - middle) * inverse
        total, product = total / count, product / count
        for i in range(len(g)):
            to_g[i] = inverse * (to_n[i] * gain[i] - total - (g[i] - middle) * inverse * product)


@compiled
def draw(logits, noise, one_hot, probs, index):
    """Draw z (B, S * C) from softmax(logits), (B, S, C), by noise (B, S), as latent.draw; index (B, S): where z is one.

    probs may be the memory of the logits.
    """
    classes = logits.shape[2]
    one_hot[:] = ZERO
    for row in range(logits.shape[0]):
        flat = probs[row].reshape(-1)
        for latent in range(logits.shape[1]):
            values, p = logits[row, latent], probs[row, latent]
            most = values[0]
            for c in range(1, classes):
                most = max(most, values[c])
            for c in range(classes):
                p[c] = values[c] - most
        for i in range(len(flat)):
            flat[i] = exp(flat[i])
        for latent in range(logits.shape[1]):
            p, total, chosen = probs[row, latent], ZERO, 0
            for c in range(classes):
                total += p[c]
            share, limit, reached = ONE / total, noise[row, latent], ZERO
            for c in range(classes):
                p[c] *= share
                reached += p[c]
                chosen += reached <= limit
            index[row, latent] = latent * classes + min(chosen, classes - 1)
            one_hot[row, index[row, latent]] = ONE


@compiled
def straight_through(probs, to_sample, to_logits, total):
    """total (B, S, C) = to_logits + the gradient of softmax from that of its sample, as latent.straight_through."""
    for row in range(probs.shape[0]):
        for latent in range(probs.shape[1]):
            p, slope, weighted = probs[row, latent], to_sample[row, latent], ZERO
            for c in range(len(p)):
                weighted += p[c] * slope[c]
            for c in range(len(p)):
                total[row, latent, c] = to_logits[row, latent, c] + p[c] * (slope[c] - weighted)
