//! What is wrong, where, against which limit: metrics of bodies and the findings made from them.
//!
//! May name `math`, `scene`, `body`. Only measures: changes nothing, hides nothing. NaN is always an error.
