//! What somebody who watches a leg would miss.

use super::*;
