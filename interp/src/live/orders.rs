//! What a command means in each state of the motion.

use arcfeed_feedrate::{LiveSection, MAX_SECTIONS};

use super::command::{Command, Excursion, LeaveBy};
use super::error::HybridError;
use super::motion::HybridMotion;
use super::state::HybridState;

impl<const N: usize> HybridMotion<'_, N> {
    /// Takes a command to heart; the motion changes with the next cycle.
    pub(super) fn tell(&mut self, command: &Command<N>) -> Result<(), HybridError> {
        if let Command::None = command {
            return Ok(());
        }
        if matches!(self.state, HybridState::Done | HybridState::Stopping | HybridState::Stopped) {
            return Err(self.not_now(command, "the motion is over; start another one"));
        }
        match *command {
            Command::None => {}
            Command::Feed(feed) => self.feed.set_feed(feed)?,
            Command::Override(factor) => self.feed.set_override(factor)?,
            Command::Section(section) => self.add_section(section)?,
            Command::ClearSections => {
                self.section_count = 0;
                self.feed.set_sections(&[])?;
            }
            Command::Hold => self.hold()?,
            Command::Resume => self.resume()?,
            Command::StepBack(place) => {
                if self.state != HybridState::TaskPath {
                    return Err(self.not_now(command, "the tool has to be on its task path"));
                }
                self.feed.step_back(place)?;
                self.held = true;
            }
            Command::Leave(excursion) => self.leave(excursion)?,
            Command::Return => self.go_back(command)?,
            Command::Stop => {
                self.halt()?;
                self.state = HybridState::Stopping;
            }
        }
        Ok(())
    }

    fn not_now(&self, command: &Command<N>, rule: &'static str) -> HybridError {
        let command = match command {
            Command::None => "nothing",
            Command::Feed(_) => "a new feed",
            Command::Override(_) => "an override",
            Command::Section(_) | Command::ClearSections => "a feed section",
            Command::Hold => "hold",
            Command::Resume => "resume",
            Command::StepBack(_) => "step back",
            Command::Leave(_) => "leave",
            Command::Return => "return",
            Command::Stop => "stop",
        };
        HybridError::NotNow { command, state: self.state.name(), rule }
    }

    fn add_section(&mut self, section: LiveSection) -> Result<(), HybridError> {
        let mut all = self.sections;
        let Some(place) = all.get_mut(self.section_count) else {
            let (value, limit) = ((MAX_SECTIONS + 1) as f64, MAX_SECTIONS as f64);
            let what = "number of feed sections";
            return Err(arcfeed_feedrate::FeedError::AboveLimit { what, value, limit }.into());
        };
        *place = section;
        self.feed.set_sections(&all[..=self.section_count])?;
        self.sections = all;
        self.section_count += 1;
        Ok(())
    }

    fn hold(&mut self) -> Result<(), HybridError> {
        self.held = true;
        self.held_leaving = self.on_path && self.state == HybridState::Leaving;
        self.halt()
    }

    /// Brakes, wherever it is.
    fn halt(&mut self) -> Result<(), HybridError> {
        if self.on_path {
            self.feed.hold();
            Ok(())
        } else {
            self.joints.hold()
        }
    }

    fn resume(&mut self) -> Result<(), HybridError> {
        self.held = false;
        self.held_leaving = false;
        if !self.on_path {
            return self.joints.resume();
        }
        // While it brakes for an event the motion along the path stays held.
        if self.state == HybridState::TaskPath {
            self.feed.resume();
        }
        Ok(())
    }

    fn leave(&mut self, excursion: Excursion<N>) -> Result<(), HybridError> {
        let (lower, upper) = (self.live.joints().lower(), self.live.joints().upper());
        for (point, q) in excursion.points().iter().enumerate() {
            for (joint, &value) in q.iter().enumerate() {
                let (lower, upper) = (lower[joint], upper[joint]);
                if !(lower..=upper).contains(&value) {
                    return Err(HybridError::OutsideRange { point, joint, value, lower, upper });
                }
            }
        }
        let first = excursion.points()[0];
        if !self.on_path {
            // Already in joint space: other points, from the present motion.
            self.joints.move_by(excursion.by);
            self.joints.retarget(&first)?;
            self.excursion = Some(excursion);
            self.state = HybridState::JointMove(0);
            self.held = false;
            return Ok(());
        }
        let mut outcome = Ok(());
        self.joints.move_by(excursion.by);
        if excursion.leave == LeaveBy::AtOnce && !self.feed.is_at_rest() {
            let now = self.last;
            match self.joints.start(&now.q, &now.qd, &now.qdd, &first) {
                Ok(()) => {
                    self.feed.stand();
                    self.on_path = false;
                }
                Err(error @ HybridError::BrakesFirst { .. }) => outcome = Err(error),
                Err(error) => return Err(error),
            }
        }
        if self.on_path {
            self.feed.hold();
        }
        self.passed_count = 0;
        self.held_leaving = false;
        self.excursion = Some(excursion);
        self.state = HybridState::Leaving;
        outcome
    }

    fn go_back(&mut self, command: &Command<N>) -> Result<(), HybridError> {
        match self.state {
            HybridState::Leaving if self.on_path => {
                // It has not left yet.
                self.excursion = None;
                self.held_leaving = false;
                self.state = HybridState::TaskPath;
                if !self.held {
                    self.feed.resume();
                }
                Ok(())
            }
            HybridState::Leaving | HybridState::JointMove(_) | HybridState::Waiting => {
                self.joints.retarget(&self.way_back(self.passed_count))?;
                self.state = HybridState::Returning;
                self.held = false;
                Ok(())
            }
            HybridState::Returning | HybridState::GoingRound => Ok(()),
            _ => Err(self.not_now(command, "the path has to have been left before")),
        }
    }
}
