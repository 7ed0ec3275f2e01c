//! Sampling a planned motion of the CR7 allocates nothing, from the first setpoint on.

use std::hint::black_box;

use arcfeed_testing::Counting;
use robot_cr7::{Job, SamplePath, Task, ToolOrientation};

#[global_allocator]
static ALLOCATOR: Counting = Counting;

#[test]
fn sampling_a_motion_allocates_nothing() {
    let tangent = ToolOrientation::Tangent { axis: -nalgebra::Vector3::z_axis() };
    for orientation in [Job::default().orientation, tangent] {
        let job = Job { orientation, ..Job::default() };
        let task = Task::of_cr7(&job, &SamplePath::SixPoint.load().expect("comes with the program"));
        let task = task.expect("in reach");
        let motion = task.plan().expect("it can be followed");
        let before = Counting::count();
        let mut sampler = motion.setpoints().expect("the job's own period");
        let mut count = 0;
        for setpoint in sampler.by_ref() {
            black_box(setpoint.expect("on the path"));
            count += 1;
        }
        assert_eq!(Counting::count() - before, 0);
        assert_eq!(count, sampler.samples());
    }
    // The counter works.
    let before = Counting::count();
    black_box(Vec::<f64>::with_capacity(10));
    assert!(Counting::count() > before);
}
