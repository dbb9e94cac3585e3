//! Only this page may ask: other pages, and names that resolve here by a trick, are refused.

use axum::extract::{Request, State};
use axum::http::header::{CONTENT_SECURITY_POLICY, HOST, HeaderName, ORIGIN, X_CONTENT_TYPE_OPTIONS};
use axum::http::{HeaderMap, HeaderValue, StatusCode};
use axum::middleware::Next;
use axum::response::{IntoResponse, Response};

/// Nothing is loaded but from this server.
const POLICY: &str = "default-src 'self'; style-src 'self' 'unsafe-inline'; img-src 'self' data: blob:; \
                      frame-ancestors 'none'; base-uri 'none'; form-action 'self'";

/// Refuses requests that name another host or come from another origin.
pub async fn same_page_only(State(port): State<u16>, request: Request, next: Next) -> Response {
    if !allowed(request.headers(), port) {
        return (StatusCode::FORBIDDEN, "this server answers its own page only").into_response();
    }
    let mut response = next.run(request).await;
    let headers = response.headers_mut();
    headers.insert(CONTENT_SECURITY_POLICY, HeaderValue::from_static(POLICY));
    headers.insert(X_CONTENT_TYPE_OPTIONS, HeaderValue::from_static("nosniff"));
    response
}

fn allowed(headers: &HeaderMap, port: u16) -> bool {
    let own = [format!("127.0.0.1:{port}"), format!("localhost:{port}")];
    let text = |name: HeaderName| headers.get(name).map(|v| v.to_str().unwrap_or("?").to_owned());
    let host = text(HOST).is_some_and(|host| own.contains(&host));
    let origin = text(ORIGIN).is_none_or(|o| own.iter().any(|own| o == format!("http://{own}")));
    host && origin
}

#[cfg(test)]
mod tests {
    use super::*;

    fn asked(host: &str, origin: Option<&str>) -> bool {
        let mut headers = HeaderMap::new();
        headers.insert(HOST, host.parse().unwrap());
        if let Some(origin) = origin {
            headers.insert(ORIGIN, origin.parse().unwrap());
        }
        allowed(&headers, 7878)
    }

    #[test]
    fn only_the_own_page_is_answered() {
        assert!(asked("127.0.0.1:7878", None));
        assert!(asked("localhost:7878", Some("http://localhost:7878")));
        assert!(!asked("evil.example:7878", None));
        assert!(!asked("127.0.0.1:7878", Some("http://evil.example")));
        assert!(!asked("127.0.0.1:7878", Some("null")));
        assert!(!asked("127.0.0.1:7879", None));
    }
}
