// Motions and kinematics from C++17: a synchronised move, a tool led to a moving target, a compiled trajectory, and an
// arm forward and back.
//
//   moves TRAJECTORY.json ARM.urdf
#include "arcfeed.h"

#include <array>
#include <cmath>
#include <cstdio>
#include <memory>
#include <stdexcept>
#include <string>
#include <vector>

namespace {

void check(ArcfeedStatus status) {
    if (status != ARCFEED_OK) {
        throw std::runtime_error(arcfeed_last_error());
    }
}

void expect(bool holds, const char *what) {
    if (!holds) {
        throw std::runtime_error(std::string("not so: ") + what);
    }
}

// A value of the library that frees itself.
template <auto FREE>
struct Free {
    template <class T>
    void operator()(T *value) const { FREE(value); }
};
using Trajectory = std::unique_ptr<ArcfeedTrajectory, Free<arcfeed_trajectory_free>>;
using Projection = std::unique_ptr<ArcfeedProjection, Free<arcfeed_projection_free>>;
using JointTrajectory = std::unique_ptr<ArcfeedJointTrajectory, Free<arcfeed_joint_trajectory_free>>;
using Arm = std::unique_ptr<ArcfeedArm, Free<arcfeed_arm_free>>;

// Takes over what a constructor of the library hands out.
template <class Owner, class Make>
Owner make(Make call) {
    typename Owner::pointer raw = nullptr;
    check(call(&raw));
    return Owner(raw);
}

// From a state of motion to rest, all axes at the same time, in a whole number of cycles.
void move() {
    const std::array<ArcfeedAxisState, 3> start{{{0.0, 0.5, 0.0}, {1.0, 0.0, 0.0}, {-1.0, 0.0, -2.0}}};
    const std::array<ArcfeedAxisState, 3> target{{{1.0, 0, 0}, {0.8, 0, 0}, {-1.5, 0, 0}}};
    const ArcfeedAxisLimits each{-2, 2, -10, 10, -200, 200};
    const std::array<ArcfeedAxisLimits, 3> limits{each, each, each};
    const ArcfeedMotionOptions options{ARCFEED_SYNC_TIME, 0.0, 1e-3};
    const auto motion = make<Trajectory>([&](auto out) {
        return arcfeed_trajectory_new(3, start.data(), target.data(), limits.data(), &options, out);
    });
    double duration = 0;
    check(arcfeed_trajectory_duration(motion.get(), &duration));
    std::array<ArcfeedMotionState, 3> end{};
    check(arcfeed_trajectory_at(motion.get(), duration, 3, end.data()));
    expect(end[0].position == 1.0 && end[1].position == 0.8 && end[2].position == -1.5, "the end is the target");
    std::printf("move: %.3f s\n", duration);
}

// A tool on its way to a target that moves for half a second.
void lead() {
    const ArcfeedPoseState start{{0.4, 0, 0.3, 1, 0, 0, 0}, {}, {}};
    ArcfeedPose target{0.4, 0.3, 0.2, std::cos(0.5), 0, 0, std::sin(0.5)};
    const ArcfeedPoseLimits limits{{0.5, 3.0, 40.0}, {1.5, 8.0, 100.0}};
    const auto tool = make<Projection>([&](auto out) { return arcfeed_projection_new(&start, &target, &limits, out); });
    ArcfeedPoseState state{};
    auto status = ARCFEED_PROJECTION_RECOVERING;
    int cycles = 0;
    for (; status != ARCFEED_PROJECTION_REACHED && cycles < 10000; cycles++) {
        if (cycles < 500) {
            target.x += 1e-4;
            check(arcfeed_projection_set_target(tool.get(), &target));
        }
        check(arcfeed_projection_step(tool.get(), 1e-3, &state, &status));
    }
    const double miss = std::hypot(state.pose.x - target.x, state.pose.y - target.y, state.pose.z - target.z);
    expect(miss < 1e-12, "the tool is at its target");
    std::printf("lead: %d cycles\n", cycles);
}

// A trajectory from a file, sampled from the middle on.
void play(const char *path) {
    const auto motion = make<JointTrajectory>([&](auto out) { return arcfeed_joint_trajectory_load(path, out); });
    const size_t joints = arcfeed_joint_trajectory_joints(motion.get());
    double duration = 0;
    check(arcfeed_joint_trajectory_duration(motion.get(), &duration));
    std::vector<ArcfeedMotionState> now(joints), before(joints);
    check(arcfeed_joint_trajectory_at(motion.get(), duration / 2, joints, before.data()));
    double widest = 0;
    for (double t = duration / 2 + 1e-3; t < duration; t += 1e-3) {
        check(arcfeed_joint_trajectory_at(motion.get(), t, joints, now.data()));
        for (size_t k = 0; k < joints; k++) {
            const double mean = (now[k].velocity + before[k].velocity) / 2;
            widest = std::max(widest, std::abs(now[k].position - before[k].position - 1e-3 * mean));
        }
        before = now;
    }
    expect(widest < 1e-5, "positions follow from velocities");
    const char *name = nullptr;
    check(arcfeed_joint_trajectory_joint_name(motion.get(), 0, &name));
    std::printf("play: %zu joints from %s on, %.3f s\n", joints, name, duration);
}

// Forward and back, near the joint values and all solutions.
void reach(const Arm &arm) {
    const size_t joints = arcfeed_arm_joints(arm.get());
    std::vector<double> q(joints), found(joints), all(joints * ARCFEED_MAX_SOLUTIONS);
    for (size_t k = 0; k < joints; k++) {
        q[k] = 0.3 + 0.2 * static_cast<double>(k);
    }
    ArcfeedPose pose{}, again{};
    check(arcfeed_arm_forward(arm.get(), joints, q.data(), &pose));
    check(arcfeed_arm_inverse(arm.get(), &pose, joints, q.data(), found.data()));
    for (size_t k = 0; k < joints; k++) {
        expect(std::abs(q[k] - found[k]) < 1e-9, "the inverse near the joint values gives them");
    }
    size_t count = 0;
    check(arcfeed_arm_inverse_all(arm.get(), &pose, joints, all.data(), &count));
    for (size_t i = 0; i < count; i++) {
        check(arcfeed_arm_forward(arm.get(), joints, &all[i * joints], &again));
        const double miss = std::hypot(again.x - pose.x, again.y - pose.y, again.z - pose.z);
        expect(miss < 1e-9, "every solution reaches the pose");
    }
    std::printf("reach: %zu joints, %zu solutions\n", joints, count);
}

} // namespace

int main(int argc, char **argv) {
    if (argc != 3) {
        std::fprintf(stderr, "usage: moves TRAJECTORY.json ARM.urdf\n");
        return 2;
    }
    try {
        move();
        lead();
        play(argv[1]);
        reach(make<Arm>([](auto out) { return arcfeed_arm_builtin("cr7", out); }));
        reach(make<Arm>([&](auto out) { return arcfeed_arm_load(argv[2], nullptr, nullptr, out); }));
        // An error is a text that says what to change.
        const ArcfeedPose far_away{5, 0, 0, 1, 0, 0, 0};
        const auto arm = make<Arm>([](auto out) { return arcfeed_arm_builtin("ur5e", out); });
        std::array<double, 6> q{};
        expect(arcfeed_arm_inverse(arm.get(), &far_away, 6, q.data(), q.data()) == ARCFEED_REFUSED, "out of reach");
        std::printf("refused: %s\n", arcfeed_last_error());
    } catch (const std::exception &error) {
        std::fprintf(stderr, "%s\n", error.what());
        return 1;
    }
}
