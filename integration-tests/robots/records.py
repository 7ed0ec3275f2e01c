"""The records of robots_of_others.json, made anew with Pinocchio from the arms that stand there.

    pip install pin
    python integration-tests/robots/records.py [--count 4] [--seed 20261201]

Of each arm: `count` joint values within the range (at most one turn about 0) by seed, the pose of the tip in the frame of the base, and
the Jacobian of the tip's origin there. arcfeed has no part in it. Writes the file in place.
"""

import argparse
import json
import pathlib

import numpy as np
import pinocchio

DATA = pathlib.Path(__file__).parent.parent / "tests" / "data" / "robots_of_others.json"


def urdf(arm):
    """The links and joints of an arm as URDF."""
    lines = [f'<robot name="{arm["name"]}">']
    lines += [f'<link name="{link}"/>' for link in arm["links"]]
    for name, kind, parent, child, xyz, rpy, axis, limit, mimic in arm["joints"]:
        lines.append(f'<joint name="{name}" type="{kind}"><origin xyz="{xyz}" rpy="{rpy}"/>')
        lines.append(f'<parent link="{parent}"/><child link="{child}"/>')
        if axis:
            lines.append(f'<axis xyz="{axis}"/>')
        if limit:
            lower, upper, effort, velocity = limit.split()
            lines.append(f'<limit lower="{lower}" upper="{upper}" effort="{effort}" velocity="{velocity}"/>')
        if mimic:
            joint, multiplier = mimic.split()
            lines.append(f'<mimic joint="{joint}" multiplier="{multiplier}"/>')
        lines.append("</joint>")
    return "\n".join([*lines, "</robot>"])


def records(arm, generator, count):
    """Joint values, poses by rows (3 x 4) and Jacobians by rows (6 x N), to 14 digits behind the point."""
    model = pinocchio.buildModelFromXML(urdf(arm))
    data = model.createData()
    moving = [joint for joint in arm["joints"] if joint[7]]
    places = [model.joints[model.getJointId(joint[0])] for joint in moving]
    base, tip = model.getFrameId(arm["base"]), model.getFrameId(arm["tip"])
    lower, upper = np.array([[float(value) for value in joint[7].split()[:2]] for joint in moving]).T.clip(-np.pi, np.pi)
    for q in generator.uniform(lower, upper, (count, len(moving))).round(3):
        full = pinocchio.neutral(model)
        for place, value in zip(places, q):
            full[place.idx_q] = value
        pinocchio.computeJointJacobians(model, data, full)
        pinocchio.updateFramePlacements(model, data)
        of_base = data.oMf[base]
        columns = [place.idx_v for place in places]
        jacobian = pinocchio.getFrameJacobian(model, data, tip, pinocchio.LOCAL_WORLD_ALIGNED)[:, columns]
        pose = (of_base.inverse() * data.oMf[tip]).homogeneous[:3]
        jacobian = np.kron(np.eye(2), of_base.rotation.T) @ jacobian
        yield {"q": q.tolist(), "pose": short(pose), "jacobian": short(jacobian)}


def short(matrix):
    """Its entries by rows; what rounds to nothing is 0."""
    return [0 if value == 0 else value for value in matrix.round(14).flatten().tolist()]


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--count", type=int, default=4)
    parser.add_argument("--seed", type=int, default=20261201)
    arguments = parser.parse_args()
    file = json.loads(DATA.read_text())
    generator = np.random.default_rng(arguments.seed)
    file["records"] = f"Pinocchio {pinocchio.__version__}, seed {arguments.seed}"
    for arm in file["arms"]:
        arm["records"] = list(records(arm, generator, arguments.count))
    dense = lambda value: json.dumps(value, ensure_ascii=False, separators=(",", ":"))
    lines = []
    for arm in file["arms"]:
        head = [f'"{key}":{dense(arm[key])}' for key in ("name", "origin", "licence", "base", "tip", "links")]
        tables = [f'"{key}":[\n' + ",\n".join(map(dense, arm[key])) + "]" for key in ("joints", "records")]
        lines.append("{" + ",\n".join([",".join(head), *tables]) + "}")
    head = [f'"{key}":{dense(file[key])}' for key in ("source", "joint", "records")]
    DATA.write_text("{\n" + ",\n".join([*head, '"arms":[\n' + ",\n".join(lines) + "]"]) + "\n}\n")


if __name__ == "__main__":
    main()
