//! The plant over HTTP: free-running ticks on their own thread, requests on another
