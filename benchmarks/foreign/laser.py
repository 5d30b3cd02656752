"""A laser that looks at the left face of a block, its noise and converter; record files of four formats."""

import numpy as np

RATE_HZ, COUNT_V = 1000, 10.5 / 2**15
WHITE_V, MAINS_V, MAINS_HZ, DRIFT_V, DRIFT_S = 2e-3, 8e-4, 50.01, 8e-4, 90.0
NOTE = "SIMULATED free-rocking record; nothing in it was measured."


def reading(corner_x, corner_z, theta, height_m):
    """How far the left face has moved away [m] at a height: from its lower end and rotation."""
    x = corner_x + (height_m - corner_z) * np.tan(theta)
    return x - x[0]


def counts(moved_m, range_m, seed):
    """What the converter says, of 16 bits and ±10.5 V, with the noise of laser and mains."""
    draw, time = np.random.RandomState(seed), np.arange(moved_m.size) / RATE_HZ
    first, second, zero = *draw.uniform(0, 2 * np.pi, 2), draw.uniform(4.7, 5.3)
    volts = zero + np.round(moved_m, 7) * 10 / range_m
    volts += MAINS_V * np.sin(2 * np.pi * MAINS_HZ * time + first)
    volts += DRIFT_V * np.sin(2 * np.pi * time / DRIFT_S + second)
    volts += WHITE_V * draw.standard_normal(time.size)
    return np.rint(volts / COUNT_V).astype(np.int16)


def write(path, raw):
    """A record file of the format that its name says: .tdms, .csv, .mat or .h5."""
    {".tdms": _tdms, ".csv": _csv, ".mat": _mat, ".h5": _h5}[path.suffix](path, raw)


def _tdms(path, raw):
    from nptdms import ChannelObject, RootObject, TdmsWriter, types

    said = {
        "unit_string": "V",
        "wf_increment": 1 / RATE_HZ,
        "wf_start_offset": 0.0,
        "wf_samples": raw.size,
        "NI_Scaling_Status": "unscaled",
        "NI_Number_Of_Scales": 1,
        "NI_Scale[0]_Scale_Type": "Linear",
        "NI_Scale[0]_Linear_Slope": COUNT_V,
        "NI_Scale[0]_Linear_Y_Intercept": 0.0,
        "NI_Scale[0]_Linear_Input_Source": types.Uint32(0xFFFFFFFF),
    }
    with TdmsWriter(path) as writer:
        writer.write_segment([RootObject({"description": NOTE}), ChannelObject("test", "laser", raw, said)])


def _csv(path, raw):
    head = f"{NOTE}\nSampling rate: {RATE_HZ} Hz\nlaser [V]\n"
    path.write_text(head + "\n".join(f"{volts:.4f}" for volts in raw * COUNT_V) + "\n", encoding="utf-8")


def _mat(path, raw):
    from scipy.io import savemat

    savemat(
        path,
        {"laser": (raw * COUNT_V).round(4)[:, None], "fs": float(RATE_HZ)},
        do_compression=True,
    )
    # the date of writing, which the file begins with, would make every writing another file
    data = bytearray(path.read_bytes())
    data[:116] = f"MATLAB 5.0 MAT-file, {NOTE}".ljust(116).encode()
    path.write_bytes(data)


def _h5(path, raw):
    import h5py

    with h5py.File(path, "w") as file:
        file.attrs["description"] = NOTE
        laser = file.create_dataset("laser", data=raw, compression="gzip", compression_opts=9, shuffle=True)
        laser.attrs.update(
            {"units": "V", "scale_factor": COUNT_V, "add_offset": 0.0, "sampling_rate": RATE_HZ}
        )
