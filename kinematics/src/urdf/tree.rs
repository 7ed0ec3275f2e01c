//! The links and joints of a file, which make a tree.
//!
//! Links and joints are numbers here, and every walk takes time in proportion to the file.

use super::file::{Joint, JointType, LinkBody, Robot};
use crate::{
    dynamics::Inertial,
    error::{KinematicsError, Part},
};
use nalgebra::Isometry3;
use std::collections::{HashMap, HashSet};

/// The number of names that an error lists.
const MAX_NAMES: usize = 20;
/// The fewest joints of an arm that ends at a hand.
const TRUNK: usize = 4;
/// The most joints of a finger in a row.
const FINGER: usize = 3;
/// Customary names of the link at which an arm ends.
const MOUNTS: [&str; 2] = ["tool0", "flange"];

pub(super) struct Tree<'a> {
    robot: &'a Robot,
    links: HashMap<&'a str, usize>,
    /// The joint above each link.
    above: Vec<Option<usize>>,
    /// The joints below each link.
    below: Vec<Vec<usize>>,
    /// The links of each joint.
    ends: Vec<Ends>,
}

#[derive(Clone, Copy)]
struct Ends {
    parent: usize,
    child: usize,
}

/// The joints above a link, up to the base.
#[derive(Clone, Copy, Default)]
struct Way {
    /// The nearest moving joint.
    moving: Option<usize>,
    /// True if some joint is of a kind that no arm has, or follows another one.
    unusable: bool,
}

/// Links that do not move against each other.
struct Body {
    links: Vec<usize>,
    /// The moving joints below.
    leaving: Vec<usize>,
}

/// The joints of an arm, one after the other.
struct Trunk {
    joints: usize,
    /// What the last of them moves.
    last: Body,
    /// The joints beside them that follow others.
    rods: Vec<usize>,
}

/// Where an arm ends.
pub(super) struct Tip {
    pub(super) link: usize,
    /// The joints of a hand that go on from there.
    pub(super) fingers: Vec<usize>,
    /// The joints beside the arm that follow its own: rods and cylinders of a linkage.
    pub(super) rods: Vec<usize>,
}

pub(super) fn broken(rule: &'static str, found: impl Into<String>) -> KinematicsError {
    KinematicsError::Structure { rule, found: found.into() }
}

pub(super) fn listed<'n>(names: impl Iterator<Item = &'n str>) -> String {
    let names: Vec<&str> = names.collect();
    let shown = names[..names.len().min(MAX_NAMES)].join(", ");
    match names.len().checked_sub(MAX_NAMES) {
        None | Some(0) => shown,
        Some(more) => format!("{shown} and {more} more"),
    }
}

impl<'a> Tree<'a> {
    pub(super) fn new(robot: &'a Robot) -> Result<Self, KinematicsError> {
        let mut links = HashMap::new();
        for (number, link) in robot.links.iter().enumerate() {
            if links.insert(link.name.as_str(), number).is_some() {
                return Err(broken("each link must have a name of its own", &link.name));
            }
        }
        let mut names = HashSet::new();
        let mut above = vec![None; robot.links.len()];
        let mut below = vec![Vec::new(); robot.links.len()];
        let mut ends = Vec::with_capacity(robot.joints.len());
        for (number, joint) in robot.joints.iter().enumerate() {
            if !names.insert(joint.name.as_str()) {
                return Err(broken("each joint must have a name of its own", &joint.name));
            }
            let link = |name: &String| {
                let rule = "the links that a joint connects must be in the file";
                links.get(name.as_str()).copied().ok_or_else(|| joint.wrong(broken(rule, name)))
            };
            let (parent, child) = (link(&joint.parent)?, link(&joint.child)?);
            if let Some(other) = above[child].replace(number) {
                let found = format!("{}, {}", robot.joints[other].name, joint.name);
                let source = broken("a link must have one parent joint", found);
                return Err(source.in_part(Part::Link, &joint.child));
            }
            below[parent].push(number);
            ends.push(Ends { parent, child });
        }
        let tree = Self { robot, links, above, below, ends };
        tree.check_loops()?;
        Ok(tree)
    }

    /// Every link must be below a link without parent.
    fn check_loops(&self) -> Result<(), KinematicsError> {
        let mut reached = vec![false; self.above.len()];
        let mut open: Vec<usize> = (0..self.above.len()).filter(|link| self.above[*link].is_none()).collect();
        while let Some(link) = open.pop() {
            reached[link] = true;
            open.extend(self.below[link].iter().map(|joint| self.ends[*joint].child));
        }
        match reached.iter().position(|reached| !reached).and_then(|link| self.above[link]) {
            None => Ok(()),
            Some(joint) => {
                let joint = &self.robot.joints[joint];
                Err(joint.wrong(broken("the links must not form a loop", &joint.child)))
            }
        }
    }

    /// The number of the link called `name`.
    pub(super) fn link(&self, name: &str) -> Result<usize, KinematicsError> {
        let rule = "the link must be one of the file's";
        let unknown = || broken(rule, listed(self.names())).in_part(Part::Link, name);
        self.links.get(name).copied().ok_or_else(unknown)
    }

    pub(super) fn name(&self, link: usize) -> &'a str {
        &self.robot.links[link].name
    }

    fn names(&self) -> impl Iterator<Item = &'a str> {
        self.robot.links.iter().map(|link| link.name.as_str())
    }

    pub(super) fn joint(&self, number: usize) -> &'a Joint {
        &self.robot.joints[number]
    }

    pub(super) fn child(&self, joint: usize) -> usize {
        self.ends[joint].child
    }

    /// The joints from `base` to `tip`; none if `tip` is not below.
    pub(super) fn way(&self, base: usize, tip: usize) -> Option<Vec<usize>> {
        let mut way = Vec::new();
        let mut at = tip;
        while at != base {
            let joint = self.above[at]?;
            way.push(joint);
            at = self.ends[joint].parent;
        }
        way.reverse();
        Some(way)
    }

    /// The one link without parent.
    pub(super) fn root(&self) -> Result<usize, KinematicsError> {
        let roots: Vec<usize> = (0..self.above.len()).filter(|link| self.above[*link].is_none()).collect();
        match roots[..] {
            [root] => Ok(root),
            [] => Err(broken("there must be a link", &self.robot.name)),
            _ => {
                let rule = "there must be one link without parent, or the base link must be named";
                Err(broken(rule, listed(roots.iter().map(|link| self.name(*link)))))
            }
        }
    }

    /// The link at which the arm ends that begins at `base`: the only end of its one chain of moving joints, whatever is
    /// fixed to the links before, or else `tool0`, the customary name of the mounting face. Where fingers go on, the arm
    /// ends at the hand. Where joints that follow others branch off, the arm goes on with the one that leads to a mounting face.
    ///
    /// # Errors
    /// Lists the links at which an arm may end, in the order of the file.
    pub(super) fn tip(&self, base: usize) -> Result<Tip, KinematicsError> {
        let Trunk { joints, last, rods } = self.trunk(base);
        if joints == 0 && last.leaving.is_empty() {
            return Err(broken("there must be a moving joint below the base link", self.name(base)));
        }
        let is_hand = joints >= TRUNK && last.leaving.iter().all(|joint| self.is_finger(*joint));
        let tool0 = last.links.iter().find(|link| self.name(**link) == "tool0");
        let chosen = if last.leaving.is_empty() {
            let mut ends = last.links.iter().filter(|link| self.below[**link].is_empty());
            match (ends.next(), ends.next()) {
                (Some(end), None) => Some(end),
                _ => tool0,
            }
        } else if is_hand {
            let hand = self.ends[last.leaving[0]].parent;
            let one_hand = last.leaving.iter().all(|joint| self.ends[*joint].parent == hand);
            tool0.or_else(|| last.links.iter().find(|link| one_hand && **link == hand))
        } else {
            None
        };
        match chosen {
            Some(link) => Ok(Tip { link: *link, fingers: last.leaving, rods }),
            None => Err(self.choices(base)),
        }
    }

    /// The moving joints from `base` on as long as it is clear which one follows.
    fn trunk(&self, base: usize) -> Trunk {
        let carries = self.carry_mounts();
        let mut trunk = Trunk { joints: 0, last: self.body(base), rods: Vec::new() };
        while let Some(next) = self.goes_on(&trunk.last, &carries) {
            trunk.joints += 1;
            trunk.rods.extend(trunk.last.leaving.iter().filter(|joint| **joint != next));
            trunk.last = self.body(self.child(next));
        }
        trunk
    }

    /// The joint with which an arm goes on: the only one, or the only one that follows no other if it carries a mounting
    /// face.
    fn goes_on(&self, body: &Body, carries: &[bool]) -> Option<usize> {
        if let [next] = body.leaving[..] {
            return Some(next);
        }
        let mut free = body.leaving.iter().copied().filter(|joint| self.joint(*joint).mimic.is_none());
        match (free.next(), free.next()) {
            (Some(next), None) if carries[self.child(next)] => Some(next),
            _ => None,
        }
    }

    /// Of each link whether it is a mounting face or has one below.
    fn carry_mounts(&self) -> Vec<bool> {
        let mut carries = vec![false; self.above.len()];
        for mount in MOUNTS.iter().filter_map(|name| self.links.get(name)) {
            let mut at = Some(*mount);
            while let Some(link) = at.filter(|link| !carries[*link]) {
                carries[link] = true;
                at = self.above[link].map(|joint| self.ends[joint].parent);
            }
        }
        carries
    }

    /// What moves with `link`, above it left out.
    fn body(&self, link: usize) -> Body {
        let mut body = Body { links: vec![link], leaving: Vec::new() };
        let mut next = 0;
        while let Some(link) = body.links.get(next).copied() {
            next += 1;
            for joint in self.below[link].iter().copied() {
                if self.joint(joint).kind == JointType::Fixed {
                    body.links.push(self.child(joint));
                } else {
                    body.leaving.push(joint);
                }
            }
        }
        body
    }

    /// True if the joint slides, follows another one or is called a finger, and what it moves is no longer than a finger and
    /// does not carry the mounting face of an arm.
    fn is_finger(&self, joint: usize) -> bool {
        let first = self.joint(joint);
        let is_called_so = first.name.to_ascii_lowercase().contains("finger");
        if !(first.kind == JointType::Prismatic || first.mimic.is_some() || is_called_so) {
            return false;
        }
        let mut open = vec![(self.child(joint), 1)];
        while let Some((link, moving)) = open.pop() {
            if moving > FINGER || MOUNTS.contains(&self.name(link)) {
                return false;
            }
            let more = |joint: &usize| moving + usize::from(self.joint(*joint).kind != JointType::Fixed);
            open.extend(self.below[link].iter().map(|joint| (self.child(*joint), more(joint))));
        }
        true
    }

    /// The links at which an arm from `base` may end.
    fn choices(&self, base: usize) -> KinematicsError {
        let ways = self.ways(base);
        let moving = |link: usize| ways[link].and_then(|way| way.moving);
        let is_end = |link: usize| self.below[link].is_empty() && moving(link).is_some();
        let offered = self.before_branches(|link| moving(link).is_some());
        let usable = |link: &usize| ways[*link].is_some_and(|way| !way.unusable);
        let tips = (0..self.above.len()).filter(|link| offered[*link] || is_end(*link)).filter(usable);
        let rule = "there must be one link at the end, or the tip link must be named, one of these";
        broken(rule, listed(tips.map(|link| self.name(link))))
    }

    /// The joints above each link that is below `base`, or is it.
    fn ways(&self, base: usize) -> Vec<Option<Way>> {
        let mut ways = vec![None; self.above.len()];
        let mut open = vec![(base, Way::default())];
        while let Some((link, way)) = open.pop() {
            ways[link] = Some(way);
            for number in &self.below[link] {
                let joint = self.joint(*number);
                let unusable = way.unusable || joint.mimic.is_some() || matches!(joint.kind, JointType::Other(_));
                let moving = if joint.kind == JointType::Fixed { way.moving } else { Some(*number) };
                open.push((self.child(*number), Way { moving, unusable }));
            }
        }
        ways
    }

    /// The links that carry a branching of the tree: those from which two or more joints go on, and
    /// those that such a link is fixed to. A hand between two fingers is one, and so is the flange
    /// that carries it.
    fn before_branches(&self, is_below: impl Fn(usize) -> bool) -> Vec<bool> {
        let mut offered = vec![false; self.above.len()];
        for link in (0..self.above.len()).filter(|link| self.below[*link].len() > 1) {
            let mut at = link;
            while is_below(at) && !offered[at] {
                offered[at] = true;
                match self.above[at].filter(|joint| self.joint(*joint).kind == JointType::Fixed) {
                    Some(joint) => at = self.ends[joint].parent,
                    None => break,
                }
            }
        }
        offered
    }

    /// Joins to `found` what hangs on `link` by fixed joints, those of `way` left out; `link`
    /// stands at `at` in the frame of the body. Returns why the whole is unknown, if a part is impossible.
    pub(super) fn join_rigid(
        &self,
        link: usize,
        at: Isometry3<f64>,
        way: &HashSet<usize>,
        found: &mut Option<Inertial>,
    ) -> Result<Option<KinematicsError>, KinematicsError> {
        let mut impossible = None;
        let mut open = vec![(link, at)];
        while let Some((link, at)) = open.pop() {
            match self.robot.links[link].body()? {
                LinkBody::Massless => {}
                LinkBody::Known(body) => {
                    let body = body.seen_from(&at);
                    *found = Some(found.map_or(body, |found| found.joined(&body)));
                }
                LinkBody::Impossible(why) => impossible = impossible.or(Some(why)),
            }
            for number in self.below[link].iter().filter(|number| !way.contains(number)) {
                let joint = self.joint(*number);
                if joint.kind == JointType::Fixed {
                    open.push((self.child(*number), at * joint.origin()?));
                }
            }
        }
        Ok(impossible)
    }
}
