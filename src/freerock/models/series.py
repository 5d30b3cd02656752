"""Free rocking by Taylor series in time: a block with sharp edges, the geometric rule of debonding, a base that
is level or leans.

With the depth Z = z_cb - h cosθ of the centre of mass, its place sideways x = h sinθ - a cosθ, and s = sinθ,
equation (1) of Spanos et al. 2017 (doi:10.1016/j.proeng.2017.09.024) divided by the mass reads

    Z̈ = g - F,    J θ̈ = s (h F - a X) - cosθ (M + h X),    X = ẍ - ẍ_g,    J = I_cm/m,

with the force F and the moment M cosθ of the foundation about the base centre; a is 0 of a guided block, and
of one that pivots b while θ > 0, -b while θ < 0. On a base that leans by τ (`ground.tilted`) ẍ_g is g sinτ, and
g cosτ stands for g; else ẍ_g is 0. While one corner is down, of depth D, on a length L = D/s, and with A = D L,

    F = k/2 A + c/2 Ȧ + λ/6 (D A)˙,    M = b F - k/6 A L - c/6 (A L)˙ - λ/24 (A²)˙;

while the whole base is,

    F = 2b (k z_cb + c ż_cb) + b λ (z_cb²)˙ + λ b³/3 (s²)˙,    M = 2b³/3 (k s + c ṡ + λ (z_cb s)˙),

and none in the air. So the coefficients of the motion follow order by order from sums of products, without an
evaluation of the law at further instants, and so does the length of the step (Jorba and Zou 2005,
doi:10.1080/10586458.2005.10128904). A step ends where a corner leaves or meets the ground, or where another
corner is turned about: a root of the series itself.

All that is compiled stands in this file: numba's cache notices a change in the file of the cached function
only. The recurrences are written out order by order, by `recurrences`: as loops they take several times as
long.
"""

import math

import numpy as np

from freerock.arrays import Floats
from freerock.models import kernel
from freerock.models.compiled import compiled

ORDER = 10
COMPLETED, AT_REST, OVERTURNED, STEP_LIMIT, NON_FINITE, STIFF = range(6)
STABLE = 3.0  # times one over the fastest rate of the contact: steps as long are held by stability
PATIENCE = 300  # such steps more than shorter ones, after which the law is stiff
SHARPER = 0.05  # of the tolerance, as a rate: what the last terms of a step may be
ONE = np.float64(1.0).view(np.int64)  # its bits
FAST = {"contract", "reassoc", "nsz"}  # of floating-point arithmetic; NaN and infinity stay what they are


# Written by `python -m freerock.models.recurrences`.
# fmt: off
@compiled(fastmath=FAST, forceinline=True)
def _corner(z, t, z0, v0, t0, w0, s0, c0, a, law):
    k, c, lam, b, h, J, g, ground = law
    z1, t1 = v0, w0
    lever = h*c0 + a*s0
    by_inertia = 1 / (J + lever*lever)
    by_slope = 1 / s0
    d0 = z0 + h*c0 + b*s0
    l0 = d0*by_slope
    a0 = d0*l0
    al0, da0, aa0 = a0*l0, d0*a0, a0*a0
    s1 = (c0*w0)*(1/1)
    c1 = -(s0*w0)*(1/1)
    d1 = z1 + h*c1 + b*s1
    l1 = (d1 - s1*l0)*by_slope
    a1 = (d0*l1 + d1*l0)
    al1 = (a0*l1 + a1*l0)
    da1 = (d0*a1 + d1*a0)
    aa1 = 2.0*a0*a1
    f0 = k*(1/2)*a0 + 1.0*(c*(1/2)*a1 + lam*(1/6)*da1)
    e0 = k*(1/6)*al0 + 1.0*(c*(1/6)*al1 + lam*(1/24)*aa1) - b*f0
    z2 = (g - f0)*(1/2)
    cw1 = c1*w0
    sw1 = s1*w0
    x1 = 1.0*(h*cw1 + a*sw1) - ground
    f0 = h*f0 - a*x1
    e0 = e0 - h*x1
    w1 = (s0*f0 + c0*e0)*(by_inertia*(1/1))
    t2 = w1*(1/2)
    f0 = f0 - a*lever*1.0*w1
    e0 = e0 - h*lever*1.0*w1
    s2 = (cw1 + c0*w1)*(1/2)
    c2 = -(sw1 + s0*w1)*(1/2)
    d2 = z2 + h*c2 + b*s2
    l2 = (d2 - (s1*l1 + s2*l0))*by_slope
    a2 = ((d1*l1 + d0*l2) + d2*l0)
    al2 = ((a1*l1 + a0*l2) + a2*l0)
    da2 = ((d1*a1 + d0*a2) + d2*a0)
    aa2 = (a1*a1 + 2.0*a0*a2)
    f1 = k*(1/2)*a1 + 2.0*(c*(1/2)*a2 + lam*(1/6)*da2)
    e1 = k*(1/6)*al1 + 2.0*(c*(1/6)*al2 + lam*(1/24)*aa2) - b*f1
    z3 = (-f1)*(1/6)
    cw2 = (c1*w1 + c2*w0)
    sw2 = (s1*w1 + s2*w0)
    x2 = 2.0*(h*cw2 + a*sw2)
    f1 = h*f1 - a*x2
    e1 = e1 - h*x2
    w2 = (((s1*f0 + c1*e0) + s0*f1) + c0*e1)*(by_inertia*(1/2))
    t3 = w2*(1/3)
    f1 = f1 - a*lever*2.0*w2
    e1 = e1 - h*lever*2.0*w2
    s3 = (cw2 + c0*w2)*(1/3)
    c3 = -(sw2 + s0*w2)*(1/3)
    d3 = z3 + h*c3 + b*s3
    l3 = (d3 - ((s1*l2 + s2*l1) + s3*l0))*by_slope
    a3 = (((d1*l2 + d2*l1) + d0*l3) + d3*l0)
    al3 = (((a1*l2 + a2*l1) + a0*l3) + a3*l0)
    da3 = (((d1*a2 + d2*a1) + d0*a3) + d3*a0)
    aa3 = (2.0*a1*a2 + 2.0*a0*a3)
    f2 = k*(1/2)*a2 + 3.0*(c*(1/2)*a3 + lam*(1/6)*da3)
    e2 = k*(1/6)*al2 + 3.0*(c*(1/6)*al3 + lam*(1/24)*aa3) - b*f2
    z4 = (-f2)*(1/12)
    cw3 = ((c1*w2 + c2*w1) + c3*w0)
    sw3 = ((s1*w2 + s2*w1) + s3*w0)
    x3 = 3.0*(h*cw3 + a*sw3)
    f2 = h*f2 - a*x3
    e2 = e2 - h*x3
    w3 = ((((s1*f1 + s2*f0) + (c1*e1 + c2*e0)) + s0*f2) + c0*e2)*(by_inertia*(1/3))
    t4 = w3*(1/4)
    f2 = f2 - a*lever*3.0*w3
    e2 = e2 - h*lever*3.0*w3
    s4 = (cw3 + c0*w3)*(1/4)
    c4 = -(sw3 + s0*w3)*(1/4)
    d4 = z4 + h*c4 + b*s4
    l4 = (d4 - (((s2*l2 + s1*l3) + s3*l1) + s4*l0))*by_slope
    a4 = ((((d2*l2 + d1*l3) + d3*l1) + d0*l4) + d4*l0)
    al4 = ((((a2*l2 + a1*l3) + a3*l1) + a0*l4) + a4*l0)
    da4 = ((((d2*a2 + d1*a3) + d3*a1) + d0*a4) + d4*a0)
    aa4 = ((a2*a2 + 2.0*a1*a3) + 2.0*a0*a4)
    f3 = k*(1/2)*a3 + 4.0*(c*(1/2)*a4 + lam*(1/6)*da4)
    e3 = k*(1/6)*al3 + 4.0*(c*(1/6)*al4 + lam*(1/24)*aa4) - b*f3
    z5 = (-f3)*(1/20)
    cw4 = (((c2*w2 + c1*w3) + c3*w1) + c4*w0)
    sw4 = (((s2*w2 + s1*w3) + s3*w1) + s4*w0)
    x4 = 4.0*(h*cw4 + a*sw4)
    f3 = h*f3 - a*x4
    e3 = e3 - h*x4
    w4 = (((((s1*f2 + s2*f1) + s3*f0) + ((c1*e2 + c2*e1) + c3*e0)) + s0*f3) + c0*e3)*(by_inertia*(1/4))
    t5 = w4*(1/5)
    f3 = f3 - a*lever*4.0*w4
    e3 = e3 - h*lever*4.0*w4
    s5 = (cw4 + c0*w4)*(1/5)
    c5 = -(sw4 + s0*w4)*(1/5)
    d5 = z5 + h*c5 + b*s5
    l5 = (d5 - ((((s2*l3 + s3*l2) + s1*l4) + s4*l1) + s5*l0))*by_slope
    a5 = (((((d2*l3 + d3*l2) + d1*l4) + d4*l1) + d0*l5) + d5*l0)
    al5 = (((((a2*l3 + a3*l2) + a1*l4) + a4*l1) + a0*l5) + a5*l0)
    da5 = (((((d2*a3 + d3*a2) + d1*a4) + d4*a1) + d0*a5) + d5*a0)
    aa5 = ((2.0*a2*a3 + 2.0*a1*a4) + 2.0*a0*a5)
    f4 = k*(1/2)*a4 + 5.0*(c*(1/2)*a5 + lam*(1/6)*da5)
    e4 = k*(1/6)*al4 + 5.0*(c*(1/6)*al5 + lam*(1/24)*aa5) - b*f4
    z6 = (-f4)*(1/30)
    cw5 = ((((c2*w3 + c3*w2) + c1*w4) + c4*w1) + c5*w0)
    sw5 = ((((s2*w3 + s3*w2) + s1*w4) + s4*w1) + s5*w0)
    x5 = 5.0*(h*cw5 + a*sw5)
    f4 = h*f4 - a*x5
    e4 = e4 - h*x5
    w5 = ((((((s2*f2 + s1*f3) + s3*f1) + s4*f0) + (((c2*e2 + c1*e3) + c3*e1) + c4*e0)) + s0*f4) + c0*e4)*(by_inertia*(1/5))
    t6 = w5*(1/6)
    f4 = f4 - a*lever*5.0*w5
    e4 = e4 - h*lever*5.0*w5
    s6 = (cw5 + c0*w5)*(1/6)
    c6 = -(sw5 + s0*w5)*(1/6)
    d6 = z6 + h*c6 + b*s6
    l6 = (d6 - (((((s3*l3 + s2*l4) + s4*l2) + s1*l5) + s5*l1) + s6*l0))*by_slope
    a6 = ((((((d3*l3 + d2*l4) + d4*l2) + d1*l5) + d5*l1) + d0*l6) + d6*l0)
    al6 = ((((((a3*l3 + a2*l4) + a4*l2) + a1*l5) + a5*l1) + a0*l6) + a6*l0)
    da6 = ((((((d3*a3 + d2*a4) + d4*a2) + d1*a5) + d5*a1) + d0*a6) + d6*a0)
    aa6 = (((a3*a3 + 2.0*a2*a4) + 2.0*a1*a5) + 2.0*a0*a6)
    f5 = k*(1/2)*a5 + 6.0*(c*(1/2)*a6 + lam*(1/6)*da6)
    e5 = k*(1/6)*al5 + 6.0*(c*(1/6)*al6 + lam*(1/24)*aa6) - b*f5
    z7 = (-f5)*(1/42)
    cw6 = (((((c3*w3 + c2*w4) + c4*w2) + c1*w5) + c5*w1) + c6*w0)
    sw6 = (((((s3*w3 + s2*w4) + s4*w2) + s1*w5) + s5*w1) + s6*w0)
    x6 = 6.0*(h*cw6 + a*sw6)
    f5 = h*f5 - a*x6
    e5 = e5 - h*x6
    w6 = (((((((s2*f3 + s3*f2) + s1*f4) + s4*f1) + s5*f0) + ((((c2*e3 + c3*e2) + c1*e4) + c4*e1) + c5*e0)) + s0*f5) + c0*e5)*(by_inertia*(1/6))
    t7 = w6*(1/7)
    f5 = f5 - a*lever*6.0*w6
    e5 = e5 - h*lever*6.0*w6
    s7 = (cw6 + c0*w6)*(1/7)
    c7 = -(sw6 + s0*w6)*(1/7)
    d7 = z7 + h*c7 + b*s7
    l7 = (d7 - ((((((s3*l4 + s4*l3) + s2*l5) + s5*l2) + s1*l6) + s6*l1) + s7*l0))*by_slope
    a7 = (((((((d3*l4 + d4*l3) + d2*l5) + d5*l2) + d1*l6) + d6*l1) + d0*l7) + d7*l0)
    al7 = (((((((a3*l4 + a4*l3) + a2*l5) + a5*l2) + a1*l6) + a6*l1) + a0*l7) + a7*l0)
    da7 = (((((((d3*a4 + d4*a3) + d2*a5) + d5*a2) + d1*a6) + d6*a1) + d0*a7) + d7*a0)
    aa7 = (((2.0*a3*a4 + 2.0*a2*a5) + 2.0*a1*a6) + 2.0*a0*a7)
    f6 = k*(1/2)*a6 + 7.0*(c*(1/2)*a7 + lam*(1/6)*da7)
    e6 = k*(1/6)*al6 + 7.0*(c*(1/6)*al7 + lam*(1/24)*aa7) - b*f6
    z8 = (-f6)*(1/56)
    cw7 = ((((((c3*w4 + c4*w3) + c2*w5) + c5*w2) + c1*w6) + c6*w1) + c7*w0)
    sw7 = ((((((s3*w4 + s4*w3) + s2*w5) + s5*w2) + s1*w6) + s6*w1) + s7*w0)
    x7 = 7.0*(h*cw7 + a*sw7)
    f6 = h*f6 - a*x7
    e6 = e6 - h*x7
    w7 = ((((((((s3*f3 + s2*f4) + s4*f2) + s1*f5) + s5*f1) + s6*f0) + (((((c3*e3 + c2*e4) + c4*e2) + c1*e5) + c5*e1) + c6*e0)) + s0*f6) + c0*e6)*(by_inertia*(1/7))
    t8 = w7*(1/8)
    f6 = f6 - a*lever*7.0*w7
    e6 = e6 - h*lever*7.0*w7
    s8 = (cw7 + c0*w7)*(1/8)
    c8 = -(sw7 + s0*w7)*(1/8)
    d8 = z8 + h*c8 + b*s8
    l8 = (d8 - (((((((s4*l4 + s3*l5) + s5*l3) + s2*l6) + s6*l2) + s1*l7) + s7*l1) + s8*l0))*by_slope
    a8 = ((((((((d4*l4 + d3*l5) + d5*l3) + d2*l6) + d6*l2) + d1*l7) + d7*l1) + d0*l8) + d8*l0)
    al8 = ((((((((a4*l4 + a3*l5) + a5*l3) + a2*l6) + a6*l2) + a1*l7) + a7*l1) + a0*l8) + a8*l0)
    da8 = ((((((((d4*a4 + d3*a5) + d5*a3) + d2*a6) + d6*a2) + d1*a7) + d7*a1) + d0*a8) + d8*a0)
    aa8 = ((((a4*a4 + 2.0*a3*a5) + 2.0*a2*a6) + 2.0*a1*a7) + 2.0*a0*a8)
    f7 = k*(1/2)*a7 + 8.0*(c*(1/2)*a8 + lam*(1/6)*da8)
    e7 = k*(1/6)*al7 + 8.0*(c*(1/6)*al8 + lam*(1/24)*aa8) - b*f7
    z9 = (-f7)*(1/72)
    cw8 = (((((((c4*w4 + c3*w5) + c5*w3) + c2*w6) + c6*w2) + c1*w7) + c7*w1) + c8*w0)
    sw8 = (((((((s4*w4 + s3*w5) + s5*w3) + s2*w6) + s6*w2) + s1*w7) + s7*w1) + s8*w0)
    x8 = 8.0*(h*cw8 + a*sw8)
    f7 = h*f7 - a*x8
    e7 = e7 - h*x8
    w8 = (((((((((s3*f4 + s4*f3) + s2*f5) + s5*f2) + s1*f6) + s6*f1) + s7*f0) + ((((((c3*e4 + c4*e3) + c2*e5) + c5*e2) + c1*e6) + c6*e1) + c7*e0)) + s0*f7) + c0*e7)*(by_inertia*(1/8))
    t9 = w8*(1/9)
    f7 = f7 - a*lever*8.0*w8
    e7 = e7 - h*lever*8.0*w8
    s9 = (cw8 + c0*w8)*(1/9)
    c9 = -(sw8 + s0*w8)*(1/9)
    d9 = z9 + h*c9 + b*s9
    l9 = (d9 - ((((((((s4*l5 + s5*l4) + s3*l6) + s6*l3) + s2*l7) + s7*l2) + s1*l8) + s8*l1) + s9*l0))*by_slope
    a9 = (((((((((d4*l5 + d5*l4) + d3*l6) + d6*l3) + d2*l7) + d7*l2) + d1*l8) + d8*l1) + d0*l9) + d9*l0)
    al9 = (((((((((a4*l5 + a5*l4) + a3*l6) + a6*l3) + a2*l7) + a7*l2) + a1*l8) + a8*l1) + a0*l9) + a9*l0)
    da9 = (((((((((d4*a5 + d5*a4) + d3*a6) + d6*a3) + d2*a7) + d7*a2) + d1*a8) + d8*a1) + d0*a9) + d9*a0)
    aa9 = ((((2.0*a4*a5 + 2.0*a3*a6) + 2.0*a2*a7) + 2.0*a1*a8) + 2.0*a0*a9)
    f8 = k*(1/2)*a8 + 9.0*(c*(1/2)*a9 + lam*(1/6)*da9)
    e8 = k*(1/6)*al8 + 9.0*(c*(1/6)*al9 + lam*(1/24)*aa9) - b*f8
    z10 = (-f8)*(1/90)
    cw9 = ((((((((c4*w5 + c5*w4) + c3*w6) + c6*w3) + c2*w7) + c7*w2) + c1*w8) + c8*w1) + c9*w0)
    sw9 = ((((((((s4*w5 + s5*w4) + s3*w6) + s6*w3) + s2*w7) + s7*w2) + s1*w8) + s8*w1) + s9*w0)
    x9 = 9.0*(h*cw9 + a*sw9)
    f8 = h*f8 - a*x9
    e8 = e8 - h*x9
    w9 = ((((((((((s4*f4 + s3*f5) + s5*f3) + s2*f6) + s6*f2) + s1*f7) + s7*f1) + s8*f0) + (((((((c4*e4 + c3*e5) + c5*e3) + c2*e6) + c6*e2) + c1*e7) + c7*e1) + c8*e0)) + s0*f8) + c0*e8)*(by_inertia*(1/9))
    t10 = w9*(1/10)
    f8 = f8 - a*lever*9.0*w9
    e8 = e8 - h*lever*9.0*w9
    z[0], t[0] = z0, t0
    z[1], t[1] = z1, t1
    z[2], t[2] = z2, t2
    z[3], t[3] = z3, t3
    z[4], t[4] = z4, t4
    z[5], t[5] = z5, t5
    z[6], t[6] = z6, t6
    z[7], t[7] = z7, t7
    z[8], t[8] = z8, t8
    z[9], t[9] = z9, t9
    z[10], t[10] = z10, t10


@compiled(fastmath=FAST, forceinline=True)
def _whole(z, t, z0, v0, t0, w0, s0, c0, a, law):
    k, c, lam, b, h, J, g, ground = law
    z1, t1 = v0, w0
    lever = h*c0 + a*s0
    by_inertia = 1 / (J + lever*lever)
    y0 = z0 + h*c0
    third = b*b*b / 3
    s1 = (c0*w0)*(1/1)
    c1 = -(s0*w0)*(1/1)
    y1 = z1 + h*c1
    yy1 = 2.0*y0*y1
    ss1 = 2.0*s0*s1
    ys1 = (y0*s1 + y1*s0)
    f0 = 2.0*b*k*y0 + 1.0*(2.0*b*c*y1 + lam*(b*yy1 + third*ss1))
    e0 = -2.0*third*(k*s0 + 1.0*(c*s1 + lam*ys1))
    z2 = (g - f0)*(1/2)
    cw1 = c1*w0
    sw1 = s1*w0
    x1 = 1.0*(h*cw1 + a*sw1) - ground
    f0 = h*f0 - a*x1
    e0 = e0 - h*x1
    w1 = (s0*f0 + c0*e0)*(by_inertia*(1/1))
    t2 = w1*(1/2)
    f0 = f0 - a*lever*1.0*w1
    e0 = e0 - h*lever*1.0*w1
    s2 = (cw1 + c0*w1)*(1/2)
    c2 = -(sw1 + s0*w1)*(1/2)
    y2 = z2 + h*c2
    yy2 = (y1*y1 + 2.0*y0*y2)
    ss2 = (s1*s1 + 2.0*s0*s2)
    ys2 = ((y1*s1 + y0*s2) + y2*s0)
    f1 = 2.0*b*k*y1 + 2.0*(2.0*b*c*y2 + lam*(b*yy2 + third*ss2))
    e1 = -2.0*third*(k*s1 + 2.0*(c*s2 + lam*ys2))
    z3 = (-f1)*(1/6)
    cw2 = (c1*w1 + c2*w0)
    sw2 = (s1*w1 + s2*w0)
    x2 = 2.0*(h*cw2 + a*sw2)
    f1 = h*f1 - a*x2
    e1 = e1 - h*x2
    w2 = (((s1*f0 + c1*e0) + s0*f1) + c0*e1)*(by_inertia*(1/2))
    t3 = w2*(1/3)
    f1 = f1 - a*lever*2.0*w2
    e1 = e1 - h*lever*2.0*w2
    s3 = (cw2 + c0*w2)*(1/3)
    c3 = -(sw2 + s0*w2)*(1/3)
    y3 = z3 + h*c3
    yy3 = (2.0*y1*y2 + 2.0*y0*y3)
    ss3 = (2.0*s1*s2 + 2.0*s0*s3)
    ys3 = (((y1*s2 + y2*s1) + y0*s3) + y3*s0)
    f2 = 2.0*b*k*y2 + 3.0*(2.0*b*c*y3 + lam*(b*yy3 + third*ss3))
    e2 = -2.0*third*(k*s2 + 3.0*(c*s3 + lam*ys3))
    z4 = (-f2)*(1/12)
    cw3 = ((c1*w2 + c2*w1) + c3*w0)
    sw3 = ((s1*w2 + s2*w1) + s3*w0)
    x3 = 3.0*(h*cw3 + a*sw3)
    f2 = h*f2 - a*x3
    e2 = e2 - h*x3
    w3 = ((((s1*f1 + s2*f0) + (c1*e1 + c2*e0)) + s0*f2) + c0*e2)*(by_inertia*(1/3))
    t4 = w3*(1/4)
    f2 = f2 - a*lever*3.0*w3
    e2 = e2 - h*lever*3.0*w3
    s4 = (cw3 + c0*w3)*(1/4)
    c4 = -(sw3 + s0*w3)*(1/4)
    y4 = z4 + h*c4
    yy4 = ((y2*y2 + 2.0*y1*y3) + 2.0*y0*y4)
    ss4 = ((s2*s2 + 2.0*s1*s3) + 2.0*s0*s4)
    ys4 = ((((y2*s2 + y1*s3) + y3*s1) + y0*s4) + y4*s0)
    f3 = 2.0*b*k*y3 + 4.0*(2.0*b*c*y4 + lam*(b*yy4 + third*ss4))
    e3 = -2.0*third*(k*s3 + 4.0*(c*s4 + lam*ys4))
    z5 = (-f3)*(1/20)
    cw4 = (((c2*w2 + c1*w3) + c3*w1) + c4*w0)
    sw4 = (((s2*w2 + s1*w3) + s3*w1) + s4*w0)
    x4 = 4.0*(h*cw4 + a*sw4)
    f3 = h*f3 - a*x4
    e3 = e3 - h*x4
    w4 = (((((s1*f2 + s2*f1) + s3*f0) + ((c1*e2 + c2*e1) + c3*e0)) + s0*f3) + c0*e3)*(by_inertia*(1/4))
    t5 = w4*(1/5)
    f3 = f3 - a*lever*4.0*w4
    e3 = e3 - h*lever*4.0*w4
    s5 = (cw4 + c0*w4)*(1/5)
    c5 = -(sw4 + s0*w4)*(1/5)
    y5 = z5 + h*c5
    yy5 = ((2.0*y2*y3 + 2.0*y1*y4) + 2.0*y0*y5)
    ss5 = ((2.0*s2*s3 + 2.0*s1*s4) + 2.0*s0*s5)
    ys5 = (((((y2*s3 + y3*s2) + y1*s4) + y4*s1) + y0*s5) + y5*s0)
    f4 = 2.0*b*k*y4 + 5.0*(2.0*b*c*y5 + lam*(b*yy5 + third*ss5))
    e4 = -2.0*third*(k*s4 + 5.0*(c*s5 + lam*ys5))
    z6 = (-f4)*(1/30)
    cw5 = ((((c2*w3 + c3*w2) + c1*w4) + c4*w1) + c5*w0)
    sw5 = ((((s2*w3 + s3*w2) + s1*w4) + s4*w1) + s5*w0)
    x5 = 5.0*(h*cw5 + a*sw5)
    f4 = h*f4 - a*x5
    e4 = e4 - h*x5
    w5 = ((((((s2*f2 + s1*f3) + s3*f1) + s4*f0) + (((c2*e2 + c1*e3) + c3*e1) + c4*e0)) + s0*f4) + c0*e4)*(by_inertia*(1/5))
    t6 = w5*(1/6)
    f4 = f4 - a*lever*5.0*w5
    e4 = e4 - h*lever*5.0*w5
    s6 = (cw5 + c0*w5)*(1/6)
    c6 = -(sw5 + s0*w5)*(1/6)
    y6 = z6 + h*c6
    yy6 = (((y3*y3 + 2.0*y2*y4) + 2.0*y1*y5) + 2.0*y0*y6)
    ss6 = (((s3*s3 + 2.0*s2*s4) + 2.0*s1*s5) + 2.0*s0*s6)
    ys6 = ((((((y3*s3 + y2*s4) + y4*s2) + y1*s5) + y5*s1) + y0*s6) + y6*s0)
    f5 = 2.0*b*k*y5 + 6.0*(2.0*b*c*y6 + lam*(b*yy6 + third*ss6))
    e5 = -2.0*third*(k*s5 + 6.0*(c*s6 + lam*ys6))
    z7 = (-f5)*(1/42)
    cw6 = (((((c3*w3 + c2*w4) + c4*w2) + c1*w5) + c5*w1) + c6*w0)
    sw6 = (((((s3*w3 + s2*w4) + s4*w2) + s1*w5) + s5*w1) + s6*w0)
    x6 = 6.0*(h*cw6 + a*sw6)
    f5 = h*f5 - a*x6
    e5 = e5 - h*x6
    w6 = (((((((s2*f3 + s3*f2) + s1*f4) + s4*f1) + s5*f0) + ((((c2*e3 + c3*e2) + c1*e4) + c4*e1) + c5*e0)) + s0*f5) + c0*e5)*(by_inertia*(1/6))
    t7 = w6*(1/7)
    f5 = f5 - a*lever*6.0*w6
    e5 = e5 - h*lever*6.0*w6
    s7 = (cw6 + c0*w6)*(1/7)
    c7 = -(sw6 + s0*w6)*(1/7)
    y7 = z7 + h*c7
    yy7 = (((2.0*y3*y4 + 2.0*y2*y5) + 2.0*y1*y6) + 2.0*y0*y7)
    ss7 = (((2.0*s3*s4 + 2.0*s2*s5) + 2.0*s1*s6) + 2.0*s0*s7)
    ys7 = (((((((y3*s4 + y4*s3) + y2*s5) + y5*s2) + y1*s6) + y6*s1) + y0*s7) + y7*s0)
    f6 = 2.0*b*k*y6 + 7.0*(2.0*b*c*y7 + lam*(b*yy7 + third*ss7))
    e6 = -2.0*third*(k*s6 + 7.0*(c*s7 + lam*ys7))
    z8 = (-f6)*(1/56)
    cw7 = ((((((c3*w4 + c4*w3) + c2*w5) + c5*w2) + c1*w6) + c6*w1) + c7*w0)
    sw7 = ((((((s3*w4 + s4*w3) + s2*w5) + s5*w2) + s1*w6) + s6*w1) + s7*w0)
    x7 = 7.0*(h*cw7 + a*sw7)
    f6 = h*f6 - a*x7
    e6 = e6 - h*x7
    w7 = ((((((((s3*f3 + s2*f4) + s4*f2) + s1*f5) + s5*f1) + s6*f0) + (((((c3*e3 + c2*e4) + c4*e2) + c1*e5) + c5*e1) + c6*e0)) + s0*f6) + c0*e6)*(by_inertia*(1/7))
    t8 = w7*(1/8)
    f6 = f6 - a*lever*7.0*w7
    e6 = e6 - h*lever*7.0*w7
    s8 = (cw7 + c0*w7)*(1/8)
    c8 = -(sw7 + s0*w7)*(1/8)
    y8 = z8 + h*c8
    yy8 = ((((y4*y4 + 2.0*y3*y5) + 2.0*y2*y6) + 2.0*y1*y7) + 2.0*y0*y8)
    ss8 = ((((s4*s4 + 2.0*s3*s5) + 2.0*s2*s6) + 2.0*s1*s7) + 2.0*s0*s8)
    ys8 = ((((((((y4*s4 + y3*s5) + y5*s3) + y2*s6) + y6*s2) + y1*s7) + y7*s1) + y0*s8) + y8*s0)
    f7 = 2.0*b*k*y7 + 8.0*(2.0*b*c*y8 + lam*(b*yy8 + third*ss8))
    e7 = -2.0*third*(k*s7 + 8.0*(c*s8 + lam*ys8))
    z9 = (-f7)*(1/72)
    cw8 = (((((((c4*w4 + c3*w5) + c5*w3) + c2*w6) + c6*w2) + c1*w7) + c7*w1) + c8*w0)
    sw8 = (((((((s4*w4 + s3*w5) + s5*w3) + s2*w6) + s6*w2) + s1*w7) + s7*w1) + s8*w0)
    x8 = 8.0*(h*cw8 + a*sw8)
    f7 = h*f7 - a*x8
    e7 = e7 - h*x8
    w8 = (((((((((s3*f4 + s4*f3) + s2*f5) + s5*f2) + s1*f6) + s6*f1) + s7*f0) + ((((((c3*e4 + c4*e3) + c2*e5) + c5*e2) + c1*e6) + c6*e1) + c7*e0)) + s0*f7) + c0*e7)*(by_inertia*(1/8))
    t9 = w8*(1/9)
    f7 = f7 - a*lever*8.0*w8
    e7 = e7 - h*lever*8.0*w8
    s9 = (cw8 + c0*w8)*(1/9)
    c9 = -(sw8 + s0*w8)*(1/9)
    y9 = z9 + h*c9
    yy9 = ((((2.0*y4*y5 + 2.0*y3*y6) + 2.0*y2*y7) + 2.0*y1*y8) + 2.0*y0*y9)
    ss9 = ((((2.0*s4*s5 + 2.0*s3*s6) + 2.0*s2*s7) + 2.0*s1*s8) + 2.0*s0*s9)
    ys9 = (((((((((y4*s5 + y5*s4) + y3*s6) + y6*s3) + y2*s7) + y7*s2) + y1*s8) + y8*s1) + y0*s9) + y9*s0)
    f8 = 2.0*b*k*y8 + 9.0*(2.0*b*c*y9 + lam*(b*yy9 + third*ss9))
    e8 = -2.0*third*(k*s8 + 9.0*(c*s9 + lam*ys9))
    z10 = (-f8)*(1/90)
    cw9 = ((((((((c4*w5 + c5*w4) + c3*w6) + c6*w3) + c2*w7) + c7*w2) + c1*w8) + c8*w1) + c9*w0)
    sw9 = ((((((((s4*w5 + s5*w4) + s3*w6) + s6*w3) + s2*w7) + s7*w2) + s1*w8) + s8*w1) + s9*w0)
    x9 = 9.0*(h*cw9 + a*sw9)
    f8 = h*f8 - a*x9
    e8 = e8 - h*x9
    w9 = ((((((((((s4*f4 + s3*f5) + s5*f3) + s2*f6) + s6*f2) + s1*f7) + s7*f1) + s8*f0) + (((((((c4*e4 + c3*e5) + c5*e3) + c2*e6) + c6*e2) + c1*e7) + c7*e1) + c8*e0)) + s0*f8) + c0*e8)*(by_inertia*(1/9))
    t10 = w9*(1/10)
    f8 = f8 - a*lever*9.0*w9
    e8 = e8 - h*lever*9.0*w9
    z[0], t[0] = z0, t0
    z[1], t[1] = z1, t1
    z[2], t[2] = z2, t2
    z[3], t[3] = z3, t3
    z[4], t[4] = z4, t4
    z[5], t[5] = z5, t5
    z[6], t[6] = z6, t6
    z[7], t[7] = z7, t7
    z[8], t[8] = z8, t8
    z[9], t[9] = z9, t9
    z[10], t[10] = z10, t10


@compiled(fastmath=FAST, forceinline=True)
def _air(z, t, z0, v0, t0, w0, s0, c0, a, law):
    k, c, lam, b, h, J, g, ground = law
    z1, t1 = v0, w0
    lever = h*c0 + a*s0
    by_inertia = 1 / (J + lever*lever)
    s1 = (c0*w0)*(1/1)
    c1 = -(s0*w0)*(1/1)
    f0 = 0.0
    e0 = 0.0
    z2 = (g - f0)*(1/2)
    cw1 = c1*w0
    sw1 = s1*w0
    x1 = 1.0*(h*cw1 + a*sw1) - ground
    f0 = h*f0 - a*x1
    e0 = e0 - h*x1
    w1 = (s0*f0 + c0*e0)*(by_inertia*(1/1))
    t2 = w1*(1/2)
    f0 = f0 - a*lever*1.0*w1
    e0 = e0 - h*lever*1.0*w1
    s2 = (cw1 + c0*w1)*(1/2)
    c2 = -(sw1 + s0*w1)*(1/2)
    f1 = 0.0
    e1 = 0.0
    z3 = (-f1)*(1/6)
    cw2 = (c1*w1 + c2*w0)
    sw2 = (s1*w1 + s2*w0)
    x2 = 2.0*(h*cw2 + a*sw2)
    f1 = h*f1 - a*x2
    e1 = e1 - h*x2
    w2 = (((s1*f0 + c1*e0) + s0*f1) + c0*e1)*(by_inertia*(1/2))
    t3 = w2*(1/3)
    f1 = f1 - a*lever*2.0*w2
    e1 = e1 - h*lever*2.0*w2
    s3 = (cw2 + c0*w2)*(1/3)
    c3 = -(sw2 + s0*w2)*(1/3)
    f2 = 0.0
    e2 = 0.0
    z4 = (-f2)*(1/12)
    cw3 = ((c1*w2 + c2*w1) + c3*w0)
    sw3 = ((s1*w2 + s2*w1) + s3*w0)
    x3 = 3.0*(h*cw3 + a*sw3)
    f2 = h*f2 - a*x3
    e2 = e2 - h*x3
    w3 = ((((s1*f1 + s2*f0) + (c1*e1 + c2*e0)) + s0*f2) + c0*e2)*(by_inertia*(1/3))
    t4 = w3*(1/4)
    f2 = f2 - a*lever*3.0*w3
    e2 = e2 - h*lever*3.0*w3
    s4 = (cw3 + c0*w3)*(1/4)
    c4 = -(sw3 + s0*w3)*(1/4)
    f3 = 0.0
    e3 = 0.0
    z5 = (-f3)*(1/20)
    cw4 = (((c2*w2 + c1*w3) + c3*w1) + c4*w0)
    sw4 = (((s2*w2 + s1*w3) + s3*w1) + s4*w0)
    x4 = 4.0*(h*cw4 + a*sw4)
    f3 = h*f3 - a*x4
    e3 = e3 - h*x4
    w4 = (((((s1*f2 + s2*f1) + s3*f0) + ((c1*e2 + c2*e1) + c3*e0)) + s0*f3) + c0*e3)*(by_inertia*(1/4))
    t5 = w4*(1/5)
    f3 = f3 - a*lever*4.0*w4
    e3 = e3 - h*lever*4.0*w4
    s5 = (cw4 + c0*w4)*(1/5)
    c5 = -(sw4 + s0*w4)*(1/5)
    f4 = 0.0
    e4 = 0.0
    z6 = (-f4)*(1/30)
    cw5 = ((((c2*w3 + c3*w2) + c1*w4) + c4*w1) + c5*w0)
    sw5 = ((((s2*w3 + s3*w2) + s1*w4) + s4*w1) + s5*w0)
    x5 = 5.0*(h*cw5 + a*sw5)
    f4 = h*f4 - a*x5
    e4 = e4 - h*x5
    w5 = ((((((s2*f2 + s1*f3) + s3*f1) + s4*f0) + (((c2*e2 + c1*e3) + c3*e1) + c4*e0)) + s0*f4) + c0*e4)*(by_inertia*(1/5))
    t6 = w5*(1/6)
    f4 = f4 - a*lever*5.0*w5
    e4 = e4 - h*lever*5.0*w5
    s6 = (cw5 + c0*w5)*(1/6)
    c6 = -(sw5 + s0*w5)*(1/6)
    f5 = 0.0
    e5 = 0.0
    z7 = (-f5)*(1/42)
    cw6 = (((((c3*w3 + c2*w4) + c4*w2) + c1*w5) + c5*w1) + c6*w0)
    sw6 = (((((s3*w3 + s2*w4) + s4*w2) + s1*w5) + s5*w1) + s6*w0)
    x6 = 6.0*(h*cw6 + a*sw6)
    f5 = h*f5 - a*x6
    e5 = e5 - h*x6
    w6 = (((((((s2*f3 + s3*f2) + s1*f4) + s4*f1) + s5*f0) + ((((c2*e3 + c3*e2) + c1*e4) + c4*e1) + c5*e0)) + s0*f5) + c0*e5)*(by_inertia*(1/6))
    t7 = w6*(1/7)
    f5 = f5 - a*lever*6.0*w6
    e5 = e5 - h*lever*6.0*w6
    s7 = (cw6 + c0*w6)*(1/7)
    c7 = -(sw6 + s0*w6)*(1/7)
    f6 = 0.0
    e6 = 0.0
    z8 = (-f6)*(1/56)
    cw7 = ((((((c3*w4 + c4*w3) + c2*w5) + c5*w2) + c1*w6) + c6*w1) + c7*w0)
    sw7 = ((((((s3*w4 + s4*w3) + s2*w5) + s5*w2) + s1*w6) + s6*w1) + s7*w0)
    x7 = 7.0*(h*cw7 + a*sw7)
    f6 = h*f6 - a*x7
    e6 = e6 - h*x7
    w7 = ((((((((s3*f3 + s2*f4) + s4*f2) + s1*f5) + s5*f1) + s6*f0) + (((((c3*e3 + c2*e4) + c4*e2) + c1*e5) + c5*e1) + c6*e0)) + s0*f6) + c0*e6)*(by_inertia*(1/7))
    t8 = w7*(1/8)
    f6 = f6 - a*lever*7.0*w7
    e6 = e6 - h*lever*7.0*w7
    s8 = (cw7 + c0*w7)*(1/8)
    c8 = -(sw7 + s0*w7)*(1/8)
    f7 = 0.0
    e7 = 0.0
    z9 = (-f7)*(1/72)
    cw8 = (((((((c4*w4 + c3*w5) + c5*w3) + c2*w6) + c6*w2) + c1*w7) + c7*w1) + c8*w0)
    sw8 = (((((((s4*w4 + s3*w5) + s5*w3) + s2*w6) + s6*w2) + s1*w7) + s7*w1) + s8*w0)
    x8 = 8.0*(h*cw8 + a*sw8)
    f7 = h*f7 - a*x8
    e7 = e7 - h*x8
    w8 = (((((((((s3*f4 + s4*f3) + s2*f5) + s5*f2) + s1*f6) + s6*f1) + s7*f0) + ((((((c3*e4 + c4*e3) + c2*e5) + c5*e2) + c1*e6) + c6*e1) + c7*e0)) + s0*f7) + c0*e7)*(by_inertia*(1/8))
    t9 = w8*(1/9)
    f7 = f7 - a*lever*8.0*w8
    e7 = e7 - h*lever*8.0*w8
    s9 = (cw8 + c0*w8)*(1/9)
    c9 = -(sw8 + s0*w8)*(1/9)
    f8 = 0.0
    e8 = 0.0
    z10 = (-f8)*(1/90)
    cw9 = ((((((((c4*w5 + c5*w4) + c3*w6) + c6*w3) + c2*w7) + c7*w2) + c1*w8) + c8*w1) + c9*w0)
    sw9 = ((((((((s4*w5 + s5*w4) + s3*w6) + s6*w3) + s2*w7) + s7*w2) + s1*w8) + s8*w1) + s9*w0)
    x9 = 9.0*(h*cw9 + a*sw9)
    f8 = h*f8 - a*x9
    e8 = e8 - h*x9
    w9 = ((((((((((s4*f4 + s3*f5) + s5*f3) + s2*f6) + s6*f2) + s1*f7) + s7*f1) + s8*f0) + (((((((c4*e4 + c3*e5) + c5*e3) + c2*e6) + c6*e2) + c1*e7) + c7*e1) + c8*e0)) + s0*f8) + c0*e8)*(by_inertia*(1/9))
    t10 = w9*(1/10)
    f8 = f8 - a*lever*9.0*w9
    e8 = e8 - h*lever*9.0*w9
    z[0], t[0] = z0, t0
    z[1], t[1] = z1, t1
    z[2], t[2] = z2, t2
    z[3], t[3] = z3, t3
    z[4], t[4] = z4, t4
    z[5], t[5] = z5, t5
    z[6], t[6] = z6, t6
    z[7], t[7] = z7, t7
    z[8], t[8] = z8, t8
    z[9], t[9] = z9, t9
    z[10], t[10] = z10, t10


@compiled(fastmath=FAST, forceinline=True)
def _both_at(z, t, x):
    a, b, v, w = z[10], t[10], 0.0, 0.0
    v, w, a, b = v*x + a, w*x + b, a*x + z[9], b*x + t[9]
    v, w, a, b = v*x + a, w*x + b, a*x + z[8], b*x + t[8]
    v, w, a, b = v*x + a, w*x + b, a*x + z[7], b*x + t[7]
    v, w, a, b = v*x + a, w*x + b, a*x + z[6], b*x + t[6]
    v, w, a, b = v*x + a, w*x + b, a*x + z[5], b*x + t[5]
    v, w, a, b = v*x + a, w*x + b, a*x + z[4], b*x + t[4]
    v, w, a, b = v*x + a, w*x + b, a*x + z[3], b*x + t[3]
    v, w, a, b = v*x + a, w*x + b, a*x + z[2], b*x + t[2]
    v, w, a, b = v*x + a, w*x + b, a*x + z[1], b*x + t[1]
    v, w, a, b = v*x + a, w*x + b, a*x + z[0], b*x + t[0]
    return a, v, b, w


@compiled(fastmath=FAST, forceinline=True)
def _fill_theta(p, sign, start, time, theta):
    p0, p1, p2, p3, p4, p5, p6, p7, p8, p9, p10 = sign*p[0], sign*p[1], sign*p[2], sign*p[3], sign*p[4], sign*p[5], sign*p[6], sign*p[7], sign*p[8], sign*p[9], sign*p[10]
    for i in range(time.size):
        x = time[i] - start
        theta[i] = ((((((((((p10*x + p9)*x + p8)*x + p7)*x + p6)*x + p5)*x + p4)*x + p3)*x + p2)*x + p1)*x + p0)
# fmt: on
# End of what is written.


@compiled(fastmath=FAST, forceinline=True)
def _sincos(x):
    """sin and cos; the Taylor polynomials are exact to the last digit for |x| < 0.6."""
    if abs(x) < 0.6:
        q = x * x
        q2 = q * q
        q4 = q2 * q2
        s = x * (
            ((1 - q * (1 / 6)) + (1 / 120 - q * (1 / 5040)) * q2)
            + ((1 / 362880 - q * (1 / 39916800)) + (1 / 6227020800 - q * (1 / 1307674368000)) * q2) * q4
        )
        c = 1 - q * (
            ((1 / 2 - q * (1 / 24)) + (1 / 720 - q * (1 / 40320)) * q2)
            + ((1 / 3628800 - q * (1 / 479001600)) + (1 / 87178291200 - q * (1 / 20922789888000)) * q2) * q4
        )
        return s, c
    return math.sin(x), math.cos(x)


@compiled(fastmath=FAST)
def _corner_at(z, t, x, side, law):
    """Depth of the corner on a side at the time x into a step, and its rate."""
    b, h = law[3], law[4]
    depth, v, theta, w = _both_at(z, t, x)
    s, cos = _sincos(theta)
    return depth + h * cos + side * b * s, v - (h * s - side * b * cos) * w


@compiled(fastmath=FAST)
def _crossing(z, t, step, side, inside, rate0, depth1, rate1, within, law):
    """Time into a step at which a corner leaves its side of the ground, or infinity.

    `inside`: whether it was in the ground when the step began; its rate then, depth and rate at the end.
    """
    low, high, depth, rate = 0.0, step, depth1, rate1
    if (depth > 0) == inside:
        # there and back within the step: it would be between the two, where the rate is zero
        if not ((rate0 < 0) == inside and rate0 * rate1 < 0):
            return math.inf
        high = step * rate0 / (rate0 - rate1)
        depth, rate = _corner_at(z, t, high, side, law)
        if (depth > 0) == inside:
            return math.inf
    x = high
    for _ in range(60):
        # Newton's step, or a bisection where it leaves the bracket
        better = x - depth / rate
        x = better if low < better < high else 0.5 * (low + high)
        depth, rate = _corner_at(z, t, x, side, law)
        if abs(depth) < within or high - low < 1e-15 * step:
            break
        if (depth > 0) == inside:
            low = x
        else:
            high = x
    return x


@compiled(fastmath=FAST)
def _passage(z, t, step):
    """Time into a step at which θ changes its sign."""
    low, high, x = 0.0, step, 0.5 * step
    positive = t[0] > 0 or (t[0] == 0 and t[1] > 0)
    for _ in range(60):
        _, _, angle, rate = _both_at(z, t, x)
        if (angle > 0) == positive:
            low = x
        else:
            high = x
        better = x - angle / rate
        if abs(better - x) < 1e-15 * step or high - low < 1e-15 * step:
            break
        x = better if low < better < high else 0.5 * (low + high)
    return x


@compiled(fastmath=FAST)
def _fill_rates(z, t, sign, start, time, h, rates):
    """z_cb, ż_cb and θ̇ at the samples of a step."""
    for i in range(time.size):
        depth, v, theta, w = _both_at(z, t, time[i] - start)
        s, cos = _sincos(theta)
        rates[i, 0], rates[i, 1], rates[i, 2] = depth + h * cos, v - h * s * w, sign * w


@compiled(forceinline=True)
def _root(x, n):
    """n-th root, up to 6.2 % too large: by the bits of the number, which are about its logarithm."""
    return np.int64(ONE + (np.float64(x).view(np.int64) - ONE) // n).view(np.float64)


@compiled(fastmath=FAST, forceinline=True)
def _length_of_step(z, t, by_width, allowed):
    """Step after which the last two terms of the rates of both series are within what is allowed, about."""
    last = ORDER * max(abs(t[ORDER]), abs(z[ORDER]) * by_width) + 1e-300
    before = (ORDER - 1) * max(abs(t[ORDER - 1]), abs(z[ORDER - 1]) * by_width) + 1e-300
    return min(_root(allowed / last, ORDER - 1), _root(allowed / before, ORDER - 2))


@compiled(fastmath=FAST, forceinline=True)
def _fastest(length, depth, law):
    """Square of the fastest rate of a contact, about: of its oscillation, or of its decay."""
    k, c, lam, b, _, J, _, _ = law
    share = length * (1 + b * b / J)
    decay = share * (c + lam * depth)
    return max(share * k, decay * decay)


@compiled(fastmath=FAST)
def _rock(law, corner, state, time, tolerance, allowed, max_steps, theta, rates):
    k, c, lam, b, h, J, g, ground = law
    p = math.sqrt(g * math.sqrt(b * b + h * h) / (J + h * h + b * b))
    theta_cr = math.atan2(b, h)
    record = rates.size > 0
    z, t = np.empty(ORDER + 1), np.empty(ORDER + 1)
    impacts = np.empty(256 if record else 0)
    # stiffness of the upright block against turning, and the energy below which it is at rest
    flat = g / (2 * b * k)
    turning = (2 / 3) * k * b * b * b - g * h
    rest = 0.5 * turning * (0.03 * tolerance) ** 2 if (c > 0 or lam > 0) and ground == 0 else -1.0
    farthest = theta_cr if ground == 0 else 0.5 * math.pi
    within = 1e-3 * allowed * b
    # where the block changes its corner, θ̈ jumps by w² times this; a step must make more of it to count
    kick, least = 2 * corner * h / (J + h * h), 0.01 * tolerance * p
    by_width, longest, shortest = 1 / b, 1 / p, 1e-15 / p

    # a block that stands on its left corner alone is seen from behind, as one on its right
    depth, v, angle, w = state
    sign, clock = 1.0, 0.0
    s, cos = _sincos(angle)
    right, left = depth + b * s > 0, depth - b * s > 0
    depth, v = depth - h * cos, v + h * s * w
    outcome = COMPLETED
    n = n_impacts = steps = stiff = 0
    while n < time.size and time[n] <= 0:
        theta[n] = angle
        if record:
            rates[n, 0], rates[n, 1], rates[n, 2] = depth + h * cos, v - h * s * w, w
        n += 1
    while n < time.size:
        if steps >= max_steps:
            outcome = STEP_LIMIT
            break
        if left and not right:
            sign, angle, w, s = -sign, -angle, -w, -s
            law = (k, c, lam, b, h, J, g, sign * ground)
            right, left = True, False
        a = corner if angle > 0 or (angle == 0 and w > 0) else -corner
        if right and left:
            _whole(z, t, depth, v, angle, w, s, cos, a, law)
        elif right:
            _corner(z, t, depth, v, angle, w, s, cos, a, law)
        else:
            _air(z, t, depth, v, angle, w, s, cos, a, law)
        step = min(_length_of_step(z, t, by_width, allowed * p), longest)
        # a contact is no longer than the base, which tells at once of most steps
        deepest = max(depth + h * cos + b * s, 0.0)
        held = right and step * step * _fastest(2 * b, deepest, law) > STABLE * STABLE
        if held and not left:
            held = step * step * _fastest(deepest / s, deepest, law) > STABLE * STABLE
        stiff = stiff + 1 if held else max(0, stiff - 1)
        if stiff == PATIENCE:
            outcome = STIFF
            break
        depth1, v1, angle1, w1 = _both_at(z, t, step)
        if not (step > shortest and abs(depth1) + abs(v1) + abs(angle1) + abs(w1) < math.inf):
            outcome = NON_FINITE
            break
        s1, cos1 = _sincos(angle1)
        base, rate, rate1 = depth1 + h * cos1, v - h * s * w, v1 - h * s1 * w1
        turn, turn1 = b * w * cos, b * w1 * cos1
        of_right = of_left = math.inf
        if (base + b * s1 > 0) != right or (rate + turn) * (rate1 + turn1) < 0:
            of_right = _crossing(
                z, t, step, 1.0, right, rate + turn, base + b * s1, rate1 + turn1, within, law
            )
        if (base - b * s1 > 0) != left or (rate - turn) * (rate1 - turn1) < 0:
            of_left = _crossing(
                z, t, step, -1.0, left, rate - turn, base - b * s1, rate1 - turn1, within, law
            )
        turned = math.inf
        if a * angle1 < 0 and kick * step * max(w * w, w1 * w1) > least:
            turned = _passage(z, t, step)
        if min(of_right, of_left, turned) < math.inf:
            step = min(of_right, of_left, turned)
            depth1, v1, angle1, w1 = _both_at(z, t, step)
            s1, cos1 = _sincos(angle1)
            # upright and not turning: what happens at one corner happens at the other
            both = angle1 == 0 and w1 == 0
            if turned < min(of_right, of_left):
                angle1, s1, cos1 = 0.0, 0.0, 1.0
            elif of_right <= of_left:
                right, left = not right, left != both
            else:
                right, left = right != both, not left

        end, first = clock + step, n
        while n + 8 < time.size and time[n + 8] <= end:
            n += 8
        while n < time.size and time[n] <= end:
            n += 1
        if n > first:
            _fill_theta(t, sign, clock, time[first:n], theta[first:n])
            if record:
                _fill_rates(z, t, sign, clock, time[first:n], h, rates[first:n])
        passes = angle * angle1 < 0 or (angle == 0 and w * angle1 < 0) or turned == step
        if record and passes:
            if n_impacts == impacts.size:
                longer = np.empty(2 * impacts.size)
                longer[:n_impacts] = impacts
                impacts = longer
            impacts[n_impacts] = clock + (step if turned == step else _passage(z, t, step))
            n_impacts += 1
        clock, depth, v, angle, w, s, cos = end, depth1, v1, angle1, w1, s1, cos1
        steps += 1
        if abs(angle) > farthest and angle * w >= 0:
            outcome = OVERTURNED
            break
        if right and left and turning > 0:
            bounce, rate = depth + h * cos - flat, v - h * s * w
            energy = k * b * bounce * bounce + 0.5 * turning * s * s
            energy += 0.5 * rate * rate + h * s * rate * w + 0.5 * (J + h * h) * w * w
            if energy < rest:
                outcome = AT_REST
                break
    if outcome != COMPLETED and outcome != STIFF:
        rests = outcome == AT_REST
        for i in range(n, time.size):
            theta[i] = 0.0 if rests else math.nan
            if record:
                rates[i, 0] = flat if rests else math.nan
                rates[i, 1] = rates[i, 2] = 0.0 if rests else math.nan
    there = depth + h * cos, v - h * s * w, sign * angle, sign * w
    return outcome, steps, n, clock, there, impacts[:n_impacts]


def integrate_series(
    law: tuple[float, ...],
    state: tuple[float, float, float, float],
    time: Floats,
    breaks: Floats,
    coefficients: Floats,
    tolerance: float,
    max_steps: int,
    theta: Floats,
    rates: Floats,
) -> tuple[int, int, int, int, int, Floats]:
    """As `kernel.integrate`, with `state` its y and `theta` its out: a block with sharp edges and its centre of
    mass over the middle, the geometric rule, a ground at rest or one that leans, as `ground.tilted` has it.

    Where the law turns out to be stiff, from there on by that. A step counts as one evaluation.
    """
    k, c, lam, b, h, inertia, g, corner, *_ = law
    ground, less = (float(coefficients[0, 0]), float(coefficients[0, 7])) if len(coefficients) else (0.0, 0.0)
    scene = (k, c, lam, b, h, inertia - h * h, g + less, ground), corner, state
    accuracy = tolerance, SHARPER * tolerance, max_steps
    outcome, steps, n, clock, there, impacts = _rock(*scene, time, *accuracy, theta, rates)
    if outcome != STIFF:
        return outcome, steps, 0, 0, steps, impacts
    later, own, *others, further = kernel.integrate(
        law,
        -1.0,
        False,
        there,
        time[n:] - clock,
        breaks - clock,
        coefficients,
        tolerance,
        max_steps - steps,
        theta[n:],
        rates[n:] if rates.size else rates,
    )
    rejected, implicit, evaluations = others
    return later, steps + own, rejected, implicit, steps + evaluations, np.append(impacts, clock + further)
