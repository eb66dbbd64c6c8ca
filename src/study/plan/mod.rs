//! What each factor of a study is and drives, and the design that draws it.

pub(super) mod factors;
mod kinds;
mod table;
