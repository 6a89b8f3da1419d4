//! Authorisation of requests: they need the page's secret token, one of the server's own addresses as host, and must come from the
//! server's own page.

use std::net::{IpAddr, SocketAddr};
use std::sync::{Arc, Mutex, PoisonError};

use axum::extract::{Request, State};
use axum::http::header::{
    CACHE_CONTROL, CONTENT_SECURITY_POLICY, CONTENT_TYPE, HOST, ORIGIN, REFERRER_POLICY,
    X_CONTENT_TYPE_OPTIONS,
};
use axum::http::{HeaderMap, HeaderName, HeaderValue, Method, StatusCode};
use axum::middleware::Next;
use axum::response::{IntoResponse, Redirect, Response};

use super::token::Token;

/// Content security policy: the page loads its own files and nothing else.
const POLICY: &str = "default-src 'none'; script-src 'self'; style-src 'self'; img-src 'self' data: blob:; connect-src 'self'; \
                      worker-src 'self'; base-uri 'none'; form-action 'none'; frame-ancestors 'none'";
/// Permissions policy: the page may write to the clipboard and use nothing else.
const PERMISSIONS: &str = "camera=(), microphone=(), geolocation=(), display-capture=(), usb=(), serial=(), hid=(), bluetooth=(), \
                           payment=(), clipboard-read=(), clipboard-write=(self)";
/// Header with which a browser states the origin of a request.
const FETCH_SITE: HeaderName = HeaderName::from_static("sec-fetch-site");

/// The secrets and host names that a request must match.
pub struct Gate {
    token: Token,
    /// A secret that leads to the page once. It is passed to the program that opens a browser, whose arguments all users of the machine
    /// can see; the token itself stays hidden.
    ticket: Mutex<Option<Token>>,
    /// Allowed host names, with the port.
    hosts: Vec<String>,
    /// The port, if the server listens on all addresses of the machine.
    any_address: Option<u16>,
}

impl Gate {
    /// The gate of a page on a server that listens at `at`.
    pub fn new(token: Token, ticket: Token, at: SocketAddr) -> Self {
        let port = at.port();
        let mut hosts = vec![at.to_string()];
        if at.ip().is_loopback() || at.ip().is_unspecified() {
            hosts.push(format!("localhost:{port}"));
        }
        Self {
            token,
            ticket: Mutex::new(Some(ticket)),
            hosts,
            any_address: at.ip().is_unspecified().then_some(port),
        }
    }

    /// Whether a host name is allowed. Names other than localhost are refused: a foreign page could reach the server through a foreign
    /// name that resolves to this machine (DNS rebinding).
    fn knows_host(&self, host: &str) -> bool {
        let host = host.to_ascii_lowercase();
        let is_address = |port: u16| {
            let address = host.parse::<SocketAddr>();
            address.is_ok_and(|a| a.port() == port) || {
                let address = host.parse::<IpAddr>();
                port == 80 && address.is_ok()
            }
        };
        self.hosts.contains(&host) || self.any_address.is_some_and(is_address)
    }

    /// Whether a request is authorised.
    fn admits(&self, request: &Request) -> bool {
        let path = request.uri().path();
        let first = path.strip_prefix('/').and_then(|p| p.split('/').next());
        // Check the token first, so that all requests without it get the same answer in the same time.
        let knows = self.token.is(first.unwrap_or(""));
        knows && self.is_own_request(request)
    }

    /// Redeems a request with the ticket: returns the path of the page and invalidates the ticket.
    fn redeem(&self, request: &Request) -> Option<String> {
        let name = request.uri().path().strip_prefix('/')?;
        let mut ticket = self.ticket.lock().unwrap_or_else(PoisonError::into_inner);
        let knows = ticket.as_ref().is_some_and(|t| t.is(name));
        if !knows || request.method() != Method::GET || !self.is_own_request(request) {
            return None;
        }
        *ticket = None;
        Some(format!("/{}/", self.token.text()))
    }

    /// Whether a request may come from the page itself, or opens it: by host, origin, method and content type.
    fn is_own_request(&self, request: &Request) -> bool {
        let path = request.uri().path();
        let authority = request.uri().authority().map(|a| a.as_str());
        let headers = request.headers();
        let host = single(headers, &HOST);
        let right_host = host.is_some_and(|h| self.knows_host(h))
            && authority.is_none_or(|a| self.knows_host(a));
        let right_origin = !headers.contains_key(ORIGIN)
            || single(headers, &ORIGIN)
                .and_then(|o| o.strip_prefix("http://"))
                .is_some_and(|o| self.knows_host(o));
        let site = single(headers, &FETCH_SITE);
        let right_method = match *request.method() {
            Method::GET | Method::HEAD => {
                let is_data = path.split('/').nth(2) == Some("api");
                !is_data
                    || !headers.contains_key(FETCH_SITE)
                    || matches!(site, Some("same-origin" | "none"))
            }
            Method::POST => {
                let typed =
                    single(headers, &CONTENT_TYPE).map(|t| t.split(';').next().unwrap_or(t).trim());
                matches!(typed, Some("application/json" | "application/octet-stream"))
                    && (!headers.contains_key(FETCH_SITE) || site == Some("same-origin"))
            }
            _ => false,
        };
        right_host && right_origin && right_method
    }
}

/// The value of a header that occurs exactly once.
fn single<'h>(headers: &'h HeaderMap, name: &HeaderName) -> Option<&'h str> {
    let mut values = headers.get_all(name).iter();
    let value = values.next()?.to_str().ok();
    value.filter(|_| values.next().is_none())
}

/// Passes authorised requests on, redirects a request with the ticket, and refuses all others without a reason. Adds security headers
/// to every response.
pub async fn authorise(State(gate): State<Arc<Gate>>, request: Request, next: Next) -> Response {
    let mut response = if gate.admits(&request) {
        next.run(request).await
    } else if let Some(page) = gate.redeem(&request) {
        Redirect::to(&page).into_response()
    } else {
        StatusCode::FORBIDDEN.into_response()
    };
    let headers = response.headers_mut();
    let fixed = HeaderValue::from_static;
    headers
        .entry(CONTENT_SECURITY_POLICY)
        .or_insert(fixed(POLICY));
    headers.insert(X_CONTENT_TYPE_OPTIONS, fixed("nosniff"));
    headers.insert(REFERRER_POLICY, fixed("no-referrer"));
    headers.insert(CACHE_CONTROL, fixed("no-store"));
    let name = HeaderName::from_static("cross-origin-resource-policy");
    headers.insert(name, fixed("same-origin"));
    let name = HeaderName::from_static("cross-origin-opener-policy");
    headers.insert(name, fixed("same-origin"));
    let name = HeaderName::from_static("permissions-policy");
    headers.insert(name, fixed(PERMISSIONS));
    response
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_ticket_leads_to_the_page_once() {
        let [token, ticket] = [(); 2].map(|()| Token::new().unwrap());
        let path = format!("/{}", ticket.text());
        let page = format!("/{}/", token.text());
        let gate = Gate::new(token, ticket, "127.0.0.1:8080".parse().unwrap());
        let asked = |method: &str, host: &str| {
            let request = Request::builder()
                .method(method)
                .uri(&path)
                .header(HOST, host);
            request.body(axum::body::Body::empty()).unwrap()
        };
        assert_eq!(gate.redeem(&asked("GET", "evil.example:8080")), None);
        assert_eq!(gate.redeem(&asked("POST", "127.0.0.1:8080")), None);
        assert!(!gate.admits(&asked("GET", "127.0.0.1:8080")));
        assert_eq!(gate.redeem(&asked("GET", "127.0.0.1:8080")), Some(page));
        assert_eq!(gate.redeem(&asked("GET", "127.0.0.1:8080")), None);
    }

    #[test]
    fn only_the_own_address_is_known() {
        let gate = |at: &str| {
            let [token, ticket] = [(); 2].map(|()| Token::new().unwrap());
            Gate::new(token, ticket, at.parse().unwrap())
        };
        let local = gate("127.0.0.1:8080");
        assert!(local.knows_host("127.0.0.1:8080") && local.knows_host("LocalHost:8080"));
        for foreign in [
            "",
            "127.0.0.1",
            "127.0.0.1:80",
            "localhost",
            "evil.example:8080",
            "127.0.0.1:8080.evil.example",
            "192.168.0.2:8080",
        ] {
            assert!(!local.knows_host(foreign), "{foreign}");
        }
        assert!(gate("[::1]:8080").knows_host("[::1]:8080"));
        let open = gate("0.0.0.0:8080");
        assert!(open.knows_host("192.168.0.2:8080") && open.knows_host("localhost:8080"));
        assert!(!open.knows_host("evil.example:8080") && !open.knows_host("192.168.0.2:81"));
    }
}
