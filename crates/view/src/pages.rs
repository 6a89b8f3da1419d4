//! The pages of one server; each has its own input file, session and secret token.

use std::sync::{PoisonError, RwLock};

use axum::Router;

use super::token::Token;

/// Upper bound of the number of pages; each keeps its meshes in memory.
const MAX_PAGES: usize = 12;

/// The router of each page, found by the token in the path of a request.
#[derive(Default)]
pub struct Pages(RwLock<Vec<(Token, Router)>>);

impl Pages {
    /// The router of the page whose token the path begins with, and whether there is one. A path without a known token goes to the first
    /// page, which refuses it.
    pub fn of(&self, path: &str) -> (Router, bool) {
        let first = path.strip_prefix('/').and_then(|p| p.split('/').next());
        let pages = self.0.read().unwrap_or_else(PoisonError::into_inner);
        let (mut found, mut is_known) = (pages.first().map(|(_, router)| router), false);
        // Compare every token, so that the time does not depend on the requested page.
        for (token, router) in pages.iter() {
            if token.is(first.unwrap_or_default()) {
                (found, is_known) = (Some(router), true);
            }
        }
        (found.cloned().unwrap_or_default(), is_known)
    }

    /// Whether another page can be added.
    pub fn has_room(&self) -> bool {
        self.0.read().unwrap_or_else(PoisonError::into_inner).len() < MAX_PAGES
    }

    /// Adds a page; false if the maximum number is reached.
    pub fn add_page(&self, token: Token, router: Router) -> bool {
        let mut pages = self.0.write().unwrap_or_else(PoisonError::into_inner);
        let has_room = pages.len() < MAX_PAGES;
        if has_room {
            pages.push((token, router));
        }
        has_room
    }
}
