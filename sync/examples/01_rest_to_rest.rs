//! Six axes from rest to rest on a straight line in joint space, printed as a table.
use arcfeed_sync::{SyncError, Trajectory, nalgebra::SVector, symmetric_limits};

fn main() -> Result<(), SyncError> {
    let limits = symmetric_limits::<6>(SVector::repeat(3.0), SVector::repeat(15.0), SVector::repeat(300.0))?;
    let start = SVector::from([0.0, -1.2, 1.0, -1.4, -1.57, 0.0]);
    let goal = SVector::from([1.5, -0.8, 0.7, -1.5, -1.57, 0.6]);
    let motion = Trajectory::rest_to_rest(start, goal, &limits, 0.0)?;
    println!("duration {:.4} s", motion.duration());
    println!("{:>8} {:>9} {:>9} {:>9}   axis 1: rad, rad/s, rad/s2", "t", "q", "qd", "qdd");
    for i in 0..=20 {
        let t = motion.duration() * f64::from(i) / 20.0;
        let state = motion.at(t);
        println!("{t:8.4} {:9.4} {:9.4} {:9.4}", state.q[0], state.qd[0], state.qdd[0]);
    }
    Ok(())
}
