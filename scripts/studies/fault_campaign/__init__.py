"""Every fault provoked, and hours driven without one: docs/fault_campaign.md."""
