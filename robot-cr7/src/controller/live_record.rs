//! What was ordered while a scenario ran, and what was refused.

use arcfeed_interp::{Command, HybridError};

use crate::input::scenario::Event;
use crate::run::online_events::Happening;
use crate::text::number;

/// The number of orders for which there is room. Who orders more does so every few cycles.
const MOST_ORDERS: usize = 1000;

/// Events and orders in the order in which they came. The memory is taken before the motion begins.
pub(super) struct LiveRecord<'s> {
    events: &'s [Event],
    rows: Vec<Row>,
    /// Orders that were taken down.
    orders: usize,
    /// Orders for which there was no room.
    missed: usize,
}

struct Row {
    /// The time of the motion at the end of the cycle, s.
    t: f64,
    /// What was ordered; `None` for the next event of the scenario.
    order: Option<Command>,
    refused: Option<HybridError>,
}

impl<'s> LiveRecord<'s> {
    pub fn new(events: &'s [Event]) -> Self {
        let rows = Vec::with_capacity(events.len() + MOST_ORDERS);
        Self { events, rows, orders: 0, missed: 0 }
    }

    /// The next event of the scenario was given.
    pub fn event(&mut self, t: f64, refused: Option<&HybridError>) {
        self.rows.push(Row { t, order: None, refused: refused.copied() });
    }

    /// This was ordered besides.
    pub fn order(&mut self, t: f64, order: &Command, refused: Option<&HybridError>) {
        if let Command::None = order {
            return;
        }
        if self.orders == MOST_ORDERS {
            self.missed += 1;
            return;
        }
        self.orders += 1;
        self.rows.push(Row { t, order: Some(*order), refused: refused.copied() });
    }

    /// All of it in words.
    pub fn happenings(&self) -> Vec<Happening> {
        let mut events = self.events.iter();
        let words = |row: &Row| {
            let what = match &row.order {
                Some(order) => format!("order: {}", order_words(order)),
                None => events.next().map(|event| event.action.words()).unwrap_or_default(),
            };
            let refused = row.refused.map(|error| format!("; refused: {error}")).unwrap_or_default();
            Happening { t_s: row.t, what: what + &refused }
        };
        let mut all: Vec<_> = self.rows.iter().map(words).collect();
        if let (true, Some(last)) = (self.missed > 0, self.rows.last()) {
            let what = format!("{} more orders, after the first {MOST_ORDERS}, are not listed", self.missed);
            all.push(Happening { t_s: last.t, what });
        }
        all
    }
}

fn order_words(order: &Command) -> String {
    match order {
        Command::Hold => "hold".to_owned(),
        Command::Resume => "resume".to_owned(),
        Command::Stop => "stop".to_owned(),
        Command::Override(share) => format!("override {} %", number(share * 100.0)),
        other => format!("{other:?}"),
    }
}
