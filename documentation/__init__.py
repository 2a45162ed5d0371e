"""The documentation's generated pages, and what MkDocs needs to build the site. It is no part of the package."""
