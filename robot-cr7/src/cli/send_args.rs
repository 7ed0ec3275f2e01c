//! The arguments of `cr7 send`.

use std::net::IpAddr;
use std::path::PathBuf;

use crate::controller::{Dialect, SendSettings};

use crate::cli::Failure;
use crate::cli::picture_files::PictureArgs;
use crate::cli::robot_args::RobotArgs;

/// The least tolerance of the following error, deg: rounded up to what a person reads.
const LEAST_FOLLOWING: f64 = 0.006;

/// Arguments of `cr7 send`.
#[derive(Debug, clap::Args)]
#[command(after_help = "Examples:
  cr7 send                                          a dry run: what would be sent, and the setpoints as a file
  cr7 send joint_trajectory.json --address 192.168.5.1
                                                    looks at mode, errors and joints; orders nothing
  cr7 send joint_trajectory.json --address 192.168.5.1 --really
                                                    leads the arm; Ctrl-C stops it
  cr7 send --job job.toml --address 192.168.5.1 --really --enable --approach
                                                    switches the drives on, and leads the arm to the start first
  cr7 send --scenario live.toml --address 192.168.5.1 --really --approach
                                                    a scenario of `cr7 run`, planned while the arm moves

Read docs/send.md before an arm moves. An emergency stop has to be in reach.
Exit code 0: done. 1: refused, or the arm was stopped on a doubt. 3: stopped on the way by an order on stdin. 130: Ctrl-C, or a hold or stop
on the way to the start.")]
pub struct Args {
    #[command(flatten)]
    pub robot: RobotArgs,
    /// joint_trajectory.json of `cr7 plan --compile-rad`, or a path as for `cr7 plan`. Without it: the path of the job, else an embedded
    /// butterfly
    pub motion: Option<PathBuf>,
    /// Scenario of `cr7 run` (TOML) instead of a motion: it is planned while the arm moves. Lines on stdin are orders: hold, resume, stop,
    /// override PERCENT
    #[arg(long, value_name = "FILE", conflicts_with_all = ["motion", "job", "unit"])]
    pub scenario: Option<PathBuf>,
    /// Job file (TOML): limits of the joints; for a path all the rest, too
    #[arg(long)]
    pub job: Option<PathBuf>,
    /// Unit of a path file that names none: mm, cm, m or in
    #[arg(long)]
    pub unit: Option<String>,
    /// Address of the controller. Without --really it is looked at, and no motion is ordered
    #[arg(long, value_name = "IP")]
    pub address: Option<IpAddr>,
    /// Lead the arm
    #[arg(long, requires = "address")]
    pub really: bool,
    /// Number by which the controller knows the arm; needed for robots other than the CR7
    #[arg(long, value_name = "N", value_parser = clap::value_parser!(u8).range(1..))]
    pub model: Option<u8>,
    /// Switch the drives on where they are off
    #[arg(long, requires = "really")]
    pub enable: bool,
    /// Lead the arm to the start of the motion from wherever it stands, with a fifth of its limits. Collisions are not looked at
    #[arg(long, requires = "address")]
    pub approach: bool,
    /// Version of the protocol
    #[arg(long, value_enum, default_value = "v4")]
    pub dialect: Version,
    /// Time between two setpoints, ms. The maker recommends 30
    #[arg(long, value_name = "MS", default_value_t = 30.0)]
    pub period_ms: f64,
    /// Distance of a joint from the start up to which the arm is led there without --approach, deg
    #[arg(long, value_name = "DEG", default_value_t = 0.5)]
    pub start_tolerance_deg: f64,
    /// Distance of a joint from what was asked of it within the lag, deg; beyond it the arm is stopped
    #[arg(long, value_name = "DEG", default_value_t = 2.0)]
    pub following_deg: f64,
    /// How long the arm may be behind, ms
    #[arg(long, value_name = "MS", default_value_t = 300.0)]
    pub lag_ms: f64,
    /// Ports of dashboard, motion (version 3) and feedback
    #[arg(long, value_name = "PORT", num_args = 3, default_values_t = [29999, 30003, 30004])]
    pub ports: Vec<u16>,
    /// Folder for setpoints, log, picture and report; created when missing
    #[arg(long, default_value = "out")]
    pub out: PathBuf,
    #[command(flatten)]
    pub pictures: PictureArgs,
    /// Print the report as one JSON object on stdout, and nothing else there
    #[arg(long)]
    pub json: bool,
}

#[derive(Debug, Clone, Copy, clap::ValueEnum)]
pub enum Version {
    /// Controllers 3.5.5 and later
    V3,
    /// Controllers 4.6.0 and later
    V4,
}

impl Args {
    pub fn dialect(&self) -> Dialect {
        match self.dialect {
            Version::V3 => Dialect::V3,
            Version::V4 => Dialect::V4,
        }
    }

    pub fn settings(&self, models: &'static [u8]) -> Result<SendSettings, Failure> {
        let wrong = |e: crate::controller::SettingsError| Failure::BadInput(e.to_string());
        if !(LEAST_FOLLOWING..=5.0).contains(&self.following_deg) {
            let words = format!("--following-deg {}: give {LEAST_FOLLOWING} to 5 degrees", self.following_deg);
            return Err(Failure::BadInput(words));
        }
        let settings = SendSettings::new(self.period_ms * 1e-3).map_err(wrong)?;
        let settings = SendSettings {
            following_tolerance: self.following_deg.to_radians(),
            lag: self.lag_ms * 1e-3,
            enable: self.enable,
            models,
            ..settings
        };
        settings.check().map_err(wrong)?;
        let least = self.dialect().least_period();
        if settings.period < least {
            let (given, least) = (self.period_ms, 1e3 * least);
            let words = format!("--period-ms {given}: {} takes {least} ms and more", self.dialect());
            return Err(Failure::BadInput(words));
        }
        if !(0.0..=5.0).contains(&self.start_tolerance_deg) {
            let words = format!(
                "--start-tolerance-deg {}: give 0 to 5 degrees, or --approach for a longer way",
                self.start_tolerance_deg
            );
            return Err(Failure::BadInput(words));
        }
        Ok(settings)
    }
}
