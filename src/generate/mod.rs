//! Proposals of people for a room: affordance search. May not name `fit` or `motion`, nor move vertices by
//! gradient: what comes out is ranked starts for the fitter. Deterministic for a given seed.
