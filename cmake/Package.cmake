# Install and package config; filled in below by targets' own install rules.
