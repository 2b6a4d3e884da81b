//! Offline learning: clips and annotations in, statistics and weights out. May not be called from the
//! document, the renderer or the editor's frame; the command line and jobs run it.
