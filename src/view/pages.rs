//! The pages of one server: each with a file, a session and a secret of its own.

use std::sync::{PoisonError, RwLock};

use axum::Router;

use super::token::Token;

/// Most files that are open at a time: each holds its meshes in memory.
const MOST: usize = 12;

/// What answers the requests of each page, by the secret in its address.
#[derive(Default)]
pub struct Desks(RwLock<Vec<(Token, Router)>>);

impl Desks {
    /// What answers a request: the page whose secret the path begins with. Without one it is the first page, which refuses it.
    pub fn of(&self, path: &str) -> Router {
        let first = path.strip_prefix('/').and_then(|p| p.split('/').next());
        let desks = self.0.read().unwrap_or_else(PoisonError::into_inner);
        let mut found = desks.first().map(|(_, router)| router);
        // All are looked at, so that the time does not depend on which page it is.
        for (token, router) in desks.iter() {
            if token.is(first.unwrap_or_default()) {
                found = Some(router);
            }
        }
        found.cloned().unwrap_or_default()
    }

    /// Whether there is room for another page.
    pub fn has_room(&self) -> bool {
        self.0.read().unwrap_or_else(PoisonError::into_inner).len() < MOST
    }

    /// Takes a page.
    pub fn add(&self, token: Token, router: Router) {
        let mut desks = self.0.write().unwrap_or_else(PoisonError::into_inner);
        desks.push((token, router));
    }
}
